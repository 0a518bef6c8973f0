"""The state of a run, as a function of its journal.

The loop changes its state only by writing an entry and then applying it. A run that was killed at any moment
is therefore restored by applying its entries again.
"""

import sys
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import Any, assert_never

from beltsort._core import Belief, SortingModel
from beltsort.cell.commands import AdvanceTo, MoveTo, Outcome, SortInto
from beltsort.errors import JournalError
from beltsort.sorting.command import Command
from beltsort.sorting.drift_state import DriftState
from beltsort.sorting.entries import (
    Answered,
    Chosen,
    CommandDone,
    CommandFailed,
    Decided,
    Drifted,
    Ended,
    Intended,
    ObjectsPassed,
    Planned,
    Requested,
    Resumed,
    ScanElsewhere,
    Scanned,
    ScanUnusable,
    Settled,
    Skipped,
    Snapshot,
    Started,
    StateChanged,
    Unheard,
)
from beltsort.sorting.entry_format import plain_belief
from beltsort.sorting.first_entry import model_of
from beltsort.sorting.holds import Answer
from beltsort.sorting.journal import Entry
from beltsort.sorting.report import Decision
from beltsort.sorting.rules import Seen


class Next(Enum):
    """The next thing that the loop does, unless a command is pending."""

    CHOOSE = "choice"
    """Choose an action."""
    SCAN = "scan"
    """Scan from the current viewpoint."""
    ADVANCE = "advance"
    """Bring the next object to the belt end."""


@dataclass
class Progress:
    """The state of a run.

    Attributes
    ----------
    model
        The model with which the belief is updated.
    belief
        Belief about the visible objects.
    run
        Name of the run, part of its commands' ids.
    first
        Number of the object at the belt end at the start.
    objects
        Number of objects to sort, empty cups included; None: until the run is told to stop.
    belt_ends
        Whether no objects follow; the belief then includes the number of objects left.
    index
        Number of the object at the belt end.
    viewpoint
        The camera's viewpoint, or the one to which it is to be moved.
    arrived
        Whether the camera is there; False at the start, and after a pause in which it may have been moved.
    steps
        Number of moves and decisions.
    commands
        Number of commands; repeated attempts do not count.
    scans
        Number of scans since the belt moved, unusable ones included.
    missed_arrivals
        Moves in a row that did not end at their viewpoint.
    stopped
        Time at which arm and belt last came to a stop, seconds on the cell's clock.
    next
        What to do next, once no command is pending.
    pending
        The command that is not known to be done, in its latest attempt.
    known_outcome
        The outcome of that attempt if it is certain: it was refused, or an operator has said so.
    settled
        The answer that a person has given to the open question from outside the process of the run, until it
        is used; None if there is none.
    bin
        Index of the cell's bin for the object at the belt end, from the decision until it has been sorted.
    visible
        What is known about each visible object besides the belief.
    drift
        State of drift detection.
    pose_faults
        Number of scans by what is likely wrong with their pose, if anything.
    decisions, skipped, passed
        The decisions, and the numbers of the objects that were skipped or passed the belt end unsorted.
    """

    model: SortingModel
    belief: Belief
    run: str = ""
    first: int = 0
    objects: int | None = 0
    belt_ends: bool = False
    index: int = 0
    viewpoint: int = 0
    arrived: bool = False
    steps: int = 0
    commands: int = 0
    scans: int = 0
    missed_arrivals: int = 0
    stopped: float = 0.0
    next: Next = Next.CHOOSE
    pending: Command | None = None
    known_outcome: Outcome | None = None
    settled: Answer | None = None
    bin: int | None = None
    visible: list[Seen] = field(default_factory=list)
    drift: DriftState = field(default_factory=DriftState)
    pose_faults: dict[str, int] = field(default_factory=dict)
    decisions: list[Decision] = field(default_factory=list)
    skipped: list[int] = field(default_factory=list)
    passed: list[int] = field(default_factory=list)

    @classmethod
    def at_start(cls, model: SortingModel) -> "Progress":
        """Return the state before the first entry."""
        return cls(model, Belief(model), visible=[Seen() for _ in range(model.positions)])

    @classmethod
    def after(cls, entries: Sequence[Entry]) -> "Progress":
        """Return the state after the entries of a run, from its start or a snapshot on.

        Raises
        ------
        JournalError
            If the first entry is another, or an entry contradicts those before it.
        """
        progress = cls.at_start(model_of(entries))
        for entry in entries:
            progress.apply(entry)
        return progress

    @property
    def done(self) -> bool:
        """Whether every object has left the belt end."""
        return self.index >= self.end and self.pending is None

    @property
    def end(self) -> int:
        """The number that follows the last object's; larger than any if their number is not limited."""
        return sys.maxsize if self.objects is None else self.first + self.objects

    @property
    def left(self) -> int | None:
        """Number of objects that have not left the belt end; None if their number is not limited."""
        return None if self.objects is None else max(0, self.end - self.index)

    @property
    def remaining(self) -> int | None:
        """Number of objects left, including the one at the belt end; None if the belt never ends."""
        return self.left if self.belt_ends else None

    @property
    def taken(self) -> bool:
        """Whether the object at the belt end has been sorted."""
        decided = bool(self.decisions) and self.decisions[-1].object == self.index
        return decided and self.bin is None

    def apply(self, entry: Entry) -> None:
        """Update the state with an entry.

        Raises
        ------
        JournalError
            If the entry contradicts those before it.
        """
        match entry.content:
            case Started() as start:
                self._start(start)
            case Resumed(drift=drift):
                self._resume(drift)
            case Intended(command):
                self.pending, self.known_outcome, self.settled = command, None, None
                self.commands += int(command.attempt == 1)
            case CommandDone(command_id, stopped=stopped):
                self._done(self._pending(command_id), stopped)
            case CommandFailed(command_id, final=final):
                self._pending(command_id)
                self.known_outcome = Outcome.NOT_DONE if final else self.known_outcome
            case Answered(command_id, outcome):
                self._pending(command_id)
                self.known_outcome, self.settled = Outcome(outcome), None
            case Settled(answer):
                self.settled = answer
            case ObjectsPassed(index):
                self._pass(index)
            case Scanned() as scan:
                self._scan(scan)
            case ScanUnusable():
                self.scans += 1
            case ScanElsewhere():
                self.scans += 1
                self.arrived, self.missed_arrivals = False, self.missed_arrivals + 1
            case Drifted():
                self.drift.reported += 1
            case Decided() as decided:
                self._decide(decided)
            case Skipped(decided=was_planned):
                self.steps += int(was_planned)
                self.skipped.append(self.index)
                self.next = Next.ADVANCE
            case Requested(action="continue"):
                self.arrived, self.missed_arrivals = False, 0  # the arm may have been moved meanwhile
            case Snapshot() as snapshot:
                self._restore(snapshot)
            case StateChanged() | Planned() | Chosen() | Requested() | Unheard() | Ended():
                pass  # information for people only
            case content:
                assert_never(content)

    def _start(self, start: Started) -> None:
        self.run, self.objects, self.belt_ends = start.run, start.objects, start.belt_ends
        self.index = self.first = start.first
        self.belief = Belief(self.model, remaining=self.remaining)
        self.drift.begin(self.model, start.drift)

    def _resume(self, drift: dict[str, Any] | None) -> None:
        self.drift.begin(self.model, drift)
        self.arrived, self.missed_arrivals = False, 0  # the arm may have been moved or repaired
        self.stopped = 0.0  # the clock may have been restarted; the arm is moved before the next scan

    def _pending(self, command_id: str) -> Command:
        """Return the pending command, to which an entry must refer."""
        if self.pending is None or self.pending.id != command_id:
            raise JournalError(
                f"the journal contains the outcome of {command_id}, which was not pending; it is damaged"
            )
        return self.pending

    def _done(self, command: Command, stopped: float | None) -> None:
        self.pending = self.known_outcome = self.settled = None
        self.stopped = max(self.stopped, stopped or 0.0)
        match command.act:
            case MoveTo(viewpoint):
                self.viewpoint, self.arrived = viewpoint, True
                if not command.arriving:
                    self.steps += 1
                    self.next = Next.SCAN
            case SortInto():
                self.bin = None
            case AdvanceTo(index):
                self._shift(index)
                looks = self.model.observe_after_decision and self.index < self.end
                self.next = Next.SCAN if looks else Next.CHOOSE
            case act:
                assert_never(act)

    def _pass(self, index: int) -> None:
        """Continue at object `index`; those that passed the belt end unsorted are lost to the run."""
        if self.bin is not None:
            self.decisions.pop()  # the object never reached its bin
        finished = self.next is Next.ADVANCE and self.bin is None  # sorted or skipped
        self.passed += range(self.index + finished, min(index, self.end))
        self.pending = self.known_outcome = self.settled = self.bin = None
        while self.index < min(index, self.end):
            self._shift(self.index + 1)
        self.next, self.arrived = Next.CHOOSE, False  # the operator may have moved the arm

    def _shift(self, index: int) -> None:
        """Update the state after an advance of the belt by one object."""
        self.index, self.scans = index, 0
        self.belief.advance()
        self.visible = [*self.visible[1:], Seen()]

    def _scan(self, scan: Scanned) -> None:
        self.scans, self.missed_arrivals = self.scans + 1, 0
        self.drift.see(self.belief, scan.viewpoint, scan.labels)
        if scan.pose_fault is not None:
            self.pose_faults[scan.pose_fault] = self.pose_faults.get(scan.pose_fault, 0) + 1
        self.belief = Belief(self.model, scan.kinds or scan.belief, scan.last_labels, self.remaining)
        dropped = {drop["position"] for drop in scan.dropped}
        for position, (seen, label) in enumerate(zip(self.visible, scan.labels, strict=True)):
            seen.looks += 1
            seen.empty = [*seen.empty, scan.viewpoint] if scan.empty[position] else []
            if label is not None:
                seen.impossible = seen.impossible + 1 if position in dropped else 0
        self.next = Next.CHOOSE

    def _decide(self, decided: Decided) -> None:
        self.steps += 1
        self.decisions.append(
            Decision(self.index, decided.label, decided.belief, decided.looks, decided.forced)
        )
        self.bin, self.next = decided.bin, Next.ADVANCE

    def snapshot(self) -> Snapshot:
        """Return the state without the objects that have left the belt."""
        return Snapshot(
            **{name: getattr(self, name) for name in _SAME_NAME},
            model=self.model.to_json(),
            glances=self.scans,
            strays=self.missed_arrivals,
            owed=self.next.value,
            told=None if self.known_outcome is None else self.known_outcome.value,
            passed=list(self.passed),
            **plain_belief(self.belief),
            visible=[replace(seen) for seen in self.visible],
            drift=self.drift.snapshot(),
            pose_faults=dict(self.pose_faults) or None,
        )

    def _restore(self, snapshot: Snapshot) -> None:
        for name in _SAME_NAME:
            setattr(self, name, getattr(snapshot, name))
        self.scans, self.missed_arrivals = snapshot.glances, snapshot.strays
        self.next = Next(snapshot.owed)
        self.known_outcome = None if snapshot.told is None else Outcome(snapshot.told)
        kinds = snapshot.kinds or snapshot.belief
        self.belief = Belief(self.model, kinds, snapshot.last_labels, self.remaining)
        self.visible = [replace(seen) for seen in snapshot.visible]
        self.passed = list(snapshot.passed)
        self.pose_faults = dict(snapshot.pose_faults or {})
        if snapshot.drift is not None:
            self.drift = DriftState.of_snapshot(self.model, snapshot.drift)


_SAME_NAME = (
    *("run", "first", "objects", "belt_ends", "index", "viewpoint", "arrived", "steps", "commands"),
    *("stopped", "bin", "pending", "settled"),
)
"""Attributes that a snapshot stores under the same name."""
