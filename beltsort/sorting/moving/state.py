"""The state of a run on a belt that never stops, as a function of its journal."""

from collections.abc import Iterable
from copy import copy
from dataclasses import asdict, dataclass, field, replace

from beltsort._core import MovingBelief, MovingBelt
from beltsort.cell.commands import MoveTo
from beltsort.cell.diverting import Diversion
from beltsort.errors import JournalError
from beltsort.sorting.entries import AnyContent, Intended
from beltsort.sorting.journal import Entry
from beltsort.sorting.moving.entries import (
    Anchored,
    BeltObject,
    DiversionTold,
    Diverting,
    EncoderJumped,
    Fate,
    FoundEmpty,
    Looked,
    MovingResumed,
    MovingSnapshot,
    MovingStarted,
    ObjectLeft,
)
from beltsort.sorting.moving.lattice import Lattice


@dataclass
class MovingState:
    """What a run on a belt that never stops knows; only entries of its journal change it.

    Attributes
    ----------
    belt
        The model, with the belt's times and prices.
    run
        Name of the run, part of its commands' ids.
    objects
        Number of objects, empty cups included; None: until the run is told to stop.
    lattice
        Where objects stand; None before the first cup was seen.
    boot_id
        The start of the controller for which coordinates hold; empty before the first cup was seen.
    viewpoint
        Where the camera stands, or was last sent to.
    commands, scans
        Number of commands and of scans.
    settled
        Every object with a smaller number is decided or has left.
    on_belt
        What is known of objects that have not left, by number; those that were neither seen nor decided are
        missing.
    fates
        Number of objects by how they left.
    bins
        Number of objects in each bin.
    confusion
        Objects in each bin by true class, shape (B, L), where the cell simulates it.
    uncounted
        Most objects that may have passed without a number, while the run was down and the controller was
        started anew.
    watched
        Time of the last scan, seconds on the cell's clock; None before the first.
    watched_exit
        Number of the object that was at the exit then.
    jumped
        The start of the controller in which the encoder jumped; empty if it never did.
    """

    belt: MovingBelt
    run: str = ""
    objects: int | None = None
    lattice: Lattice | None = None
    boot_id: str = ""
    viewpoint: int = 0
    commands: int = 0
    scans: int = 0
    settled: int = 0
    on_belt: dict[int, BeltObject] = field(default_factory=dict)
    fates: dict[str, int] = field(default_factory=dict)
    bins: list[int] = field(default_factory=list)
    confusion: list[list[int]] = field(default_factory=list)
    uncounted: int = 0
    watched: float | None = None
    watched_exit: int = 0
    jumped: str = ""

    def __post_init__(self) -> None:
        """Begin to count."""
        model = self.belt.model
        self.bins = self.bins or [0] * len(model.bins)
        self.confusion = self.confusion or [[0] * len(model.classes) for _ in model.bins]
        self._unseen = [float(p) for p in self.belt.belief().kinds[-1]]

    @classmethod
    def after(cls, entries: Iterable[Entry]) -> "MovingState":
        """Return the state after the entries of a run, from its start or a snapshot on.

        Raises
        ------
        JournalError
            If the first entry is neither, or there is none.
        """
        state: MovingState | None = None
        for entry in entries:
            if state is None:
                state = cls._beginning(entry)
            state.apply(entry.content)
        if state is None:
            raise JournalError(
                "the journal has no entries: the run was killed before it began; start it anew"
            )
        return state

    @classmethod
    def _beginning(cls, entry: Entry) -> "MovingState":
        match entry.content:
            case MovingStarted(belt=belt) | MovingSnapshot(belt=belt):
                return cls(MovingBelt.from_json(belt))
            case _:
                raise JournalError(
                    f"the journal begins with {entry.kind!r}, expected 'moving_start': this run is of a belt "
                    "that stops; resume it with the cell file that it began with"
                )

    @property
    def done(self) -> bool:
        """Whether every object of the run has left."""
        return self.objects is not None and self.settled >= self.objects and not self.on_belt

    @property
    def diversions(self) -> dict[int, BeltObject]:
        """The objects that are decided and have not left, by number."""
        return {number: known for number, known in self.on_belt.items() if known.command_id is not None}

    def known(self, number: int) -> BeltObject:
        """Return what is known of an object on the belt."""
        return self.on_belt.get(number) or BeltObject(self._unseen)

    def is_settled(self, number: int) -> bool:
        """Whether an object is decided or has left, or is none of this run's."""
        if number < self.settled or (self.objects is not None and number >= self.objects):
            return True
        return number in self.on_belt and self.on_belt[number].decided

    def is_empty(self, known: BeltObject, empty_looks: int | None) -> bool:
        """Whether a cup was seen empty so many times in a row that it is taken to be empty."""
        return empty_looks is not None and self.belt.model.empty is None and known.empty >= empty_looks

    def numbers(self, travel: float) -> range:
        """Return the numbers of the objects at the H places, the exit's first."""
        if self.lattice is None:
            return range(0)
        first = self.lattice.at_exit(travel)
        return range(first, first + self.belt.model.positions)

    def belief(self, travel: float, empty_looks: int | None = None) -> MovingBelief:
        """Return the belief about the objects at the H places, as policies get it.

        A cup that was seen empty `empty_looks` times in a row counts as decided, unless the model has a class
        for empty cups.
        """
        numbers = self.numbers(travel)
        known = [self.known(number) for number in numbers]
        assert self.lattice is not None
        to_come = None if self.objects is None else max(0, self.objects - numbers.stop)
        return MovingBelief(
            self.belt,
            kinds=[each.kinds for each in known],
            decided=[
                self.is_settled(number) or self.is_empty(each, empty_looks)
                for number, each in zip(numbers, known, strict=True)
            ],
            offset=self.lattice.offset(travel, self.belt.ticks_per_place or 1),
            to_come=to_come,
        )

    def apply(self, content: AnyContent) -> None:
        """Change the state as an entry says; entries of other kinds do not."""
        match content:
            case MovingStarted(run=run, objects=objects):
                self.run, self.objects = run, objects
            case MovingResumed(belt=belt):
                self.belt = MovingBelt.from_json(belt)
            case MovingSnapshot() as snapshot:
                self._restore(snapshot)
            case Anchored() as anchor:
                self._anchor(anchor)
            case Intended(command):
                self.commands += 1
                if isinstance(command.act, MoveTo):
                    self.viewpoint = command.act.viewpoint
            case Looked() as look:
                self._look(look)
            case Diverting() as diverting:
                self._divert(diverting)
            case FoundEmpty(number):
                self.on_belt[number] = replace(self.known(number), skipped=True)
                self._settle()
            case DiversionTold(number=number, state=told, retry=retry):
                self.on_belt[number] = replace(self.on_belt[number], state=told, retry=retry)
            case EncoderJumped(boot_id):
                self.jumped = boot_id
            case ObjectLeft(number, fate):
                self._leave(number, fate)
            case _:
                pass

    def _anchor(self, anchor: Anchored) -> None:
        self.lattice = Lattice(anchor.spacing, anchor.origin, anchor.first)
        self.boot_id = anchor.boot_id
        self.uncounted += anchor.uncounted

    def _look(self, look: Looked) -> None:
        self.scans, self.watched = self.scans + 1, look.stamp
        self.watched_exit = self.numbers(look.travel).start
        for seen in look.seen:
            before = self.known(seen.number)
            self.on_belt[seen.number] = replace(
                before,
                kinds=before.kinds if seen.kinds is None else seen.kinds,
                coordinate=before.coordinate if seen.coordinate is None else seen.coordinate,
                looks=before.looks + (seen.label is not None),
                empty=before.empty + 1 if seen.finding == "empty" else 0,
            )

    def _divert(self, diverting: Diverting) -> None:
        number = diverting.number
        self.commands += 1
        self.on_belt[number] = replace(
            self.known(number),
            command_id=diverting.command_id,
            bin=diverting.bin,
            coordinate=diverting.coordinate,
            true_class=diverting.true_class,
        )
        self._settle()

    def _leave(self, number: int, fate: Fate) -> None:
        known = self.on_belt.pop(number, None)
        self.fates[fate] = self.fates.get(fate, 0) + 1
        if fate is Fate.IN_BIN and known is not None and known.bin is not None:
            self.bins[known.bin] += 1
            if known.true_class is not None:
                self.confusion[known.bin][known.true_class] += 1
        # Objects pass the exit in order, and are told in order: no larger number has left before.
        self.settled += number == self.settled
        self._settle()

    def _settle(self) -> None:
        """Raise `settled` over the objects that are decided."""
        while (known := self.on_belt.get(self.settled)) is not None and known.decided:
            self.settled += 1

    def copy(self) -> "MovingState":
        """Return a copy that further entries do not change."""
        kept = copy(self)
        kept.on_belt, kept.fates, kept.bins = dict(self.on_belt), dict(self.fates), list(self.bins)
        kept.confusion = [list(row) for row in self.confusion]
        return kept

    def snapshot(self) -> MovingSnapshot:
        """Return the state as an entry from which it is restored."""
        lattice = self.lattice
        anchor = (
            None
            if lattice is None
            else Anchored(self.boot_id, lattice.spacing, lattice.origin, lattice.first)
        )
        return MovingSnapshot(
            run=self.run,
            objects=self.objects,
            belt=self.belt.to_json(),
            anchor=None if anchor is None else asdict(anchor),
            viewpoint=self.viewpoint,
            commands=self.commands,
            scans=self.scans,
            settled=self.settled,
            on_belt={str(number): known for number, known in self.on_belt.items()},
            fates=dict(self.fates),
            bins=list(self.bins),
            confusion=[list(row) for row in self.confusion],
            uncounted=self.uncounted,
            watched=self.watched,
            watched_exit=self.watched_exit,
            jumped=self.jumped,
        )

    def _restore(self, snapshot: MovingSnapshot) -> None:
        self.run, self.objects = snapshot.run, snapshot.objects
        if snapshot.anchor is not None:
            self._anchor(Anchored(**snapshot.anchor))
        self.viewpoint, self.commands, self.scans = snapshot.viewpoint, snapshot.commands, snapshot.scans
        self.settled = snapshot.settled
        self.on_belt = {int(number): known for number, known in snapshot.on_belt.items()}
        self.fates, self.bins = dict(snapshot.fates), list(snapshot.bins)
        self.confusion = [list(row) for row in snapshot.confusion]
        self.uncounted, self.watched = snapshot.uncounted, snapshot.watched
        self.watched_exit, self.jumped = snapshot.watched_exit, snapshot.jumped


def final_fate(state: Diversion) -> Fate:
    """Return how an object has left whose diversion is final."""
    return {
        Diversion.DONE: Fate.IN_BIN,
        Diversion.TOO_LATE: Fate.TOO_LATE,
        Diversion.NOT_DONE: Fate.NOT_DONE,
    }.get(state, Fate.UNKNOWN)
