"""How far a run has come: a function of its journal.

The loop changes its state in one way only: it writes an entry, then applies it. So a run that was killed at
any moment is brought back by applying what it wrote.
"""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from enum import Enum
from typing import Any

from beltsort._core import Belief, SortingModel
from beltsort.cell.commands import Outcome
from beltsort.errors import JournalError
from beltsort.sorting.command import Command
from beltsort.sorting.drift_state import DriftState
from beltsort.sorting.journal import Entry
from beltsort.sorting.report import Decision
from beltsort.sorting.rules import Seen


class Owed(Enum):
    """What the loop has to do next."""

    CHOICE = "choice"
    """Choose an action."""
    SCAN = "scan"
    """Scan from where the camera stands."""
    ADVANCE = "advance"
    """Bring the next object to the belt end."""


def model_of(entries: Sequence[Entry]) -> SortingModel:
    """Return the model of a run, from its entries.

    Raises
    ------
    JournalError
        If they begin with neither a start nor a snapshot.
    """
    first = entries[0]
    if first.kind not in ("start", "snapshot"):
        raise JournalError(
            f"the journal begins with {first.kind!r}, expected 'start' or 'snapshot': it is damaged"
        )
    return SortingModel.from_json(first.data["model"])


@dataclass
class Progress:
    """What the loop knows.

    Attributes
    ----------
    model
        Updates the belief.
    belief
        About the visible objects.
    run
        Name of the run, part of its commands' ids.
    first
        Number of the object at the belt end at the start.
    objects
        Belt places to work through.
    belt_ends
        Whether nothing follows them, which the belief then knows.
    index
        Number of the object at the belt end.
    viewpoint
        Where the camera stands, or is to be brought.
    arrived
        Whether it stands there; not so at the start, and after a pause in which somebody may have moved it.
    steps
        Moves and decisions so far.
    commands
        Commands so far, repeated ones once.
    glances
        Scans since the belt moved, unusable ones included.
    strays
        Moves in a row that ended at another viewpoint.
    stopped
        When arm and belt stood still last, seconds on the cell's clock.
    owed
        What to do next; a pending command goes before.
    pending
        The command that is not known to be done, in its latest attempt.
    told
        What became of that attempt, if it is certain: it was refused, or a person has said so.
    bin
        Where the object at the belt end is to be sorted, from the decision until it is done.
    visible
        What is known of each visible object besides the belief.
    drift
        What the watch over the tables has come to.
    decisions, skipped, passed
        What the report will say.
    """

    model: SortingModel
    belief: Belief
    run: str = ""
    first: int = 0
    objects: int = 0
    belt_ends: bool = False
    index: int = 0
    viewpoint: int = 0
    arrived: bool = False
    steps: int = 0
    commands: int = 0
    glances: int = 0
    strays: int = 0
    stopped: float = 0.0
    owed: Owed = Owed.CHOICE
    pending: Command | None = None
    told: Outcome | None = None
    bin: int | None = None
    visible: list[Seen] = field(default_factory=list)
    drift: DriftState = field(default_factory=DriftState)
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
            If they begin with anything else, or cannot follow each other.
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
        """Number of the object behind the last one."""
        return self.first + self.objects

    @property
    def remaining(self) -> int | None:
        """Places left to decide, the one at the belt end included; None on a belt that never ends."""
        return max(0, self.end - self.index) if self.belt_ends else None

    @property
    def taken(self) -> bool:
        """Whether the object at the belt end has been sorted."""
        decided = bool(self.decisions) and self.decisions[-1].object == self.index
        return decided and self.bin is None

    def apply(self, entry: Entry) -> None:
        """Take in one entry.

        Raises
        ------
        JournalError
            If it cannot follow the ones before.
        """
        effect = _EFFECTS.get(entry.kind)
        if effect is not None:
            effect(self, entry.data)

    def _start(self, data: dict[str, Any]) -> None:
        self.run, self.objects = data["run"], data["objects"]
        self.index = self.first = data.get("first", 0)  # older files begin with object 0
        self.belt_ends = data.get("belt_ends", False)  # and do not tell
        self.belief = Belief(self.model, remaining=self.remaining)
        self.drift.begin(self.model, data.get("drift"))

    def _resume(self, data: dict[str, Any]) -> None:
        self.drift.begin(self.model, data.get("drift"))
        self.arrived, self.strays = False, 0  # somebody has seen to the arm
        self.stopped = 0.0  # the clock may be another one since; the arm is moved before the next scan

    def _intent(self, data: dict[str, Any]) -> None:
        self.pending, self.told = Command(**data["command"]), None
        self.commands += int(self.pending.attempt == 1)

    def _told(self, data: dict[str, Any]) -> None:
        self._check_pending(data)
        self.told = Outcome(data["outcome"])

    def _outcome(self, data: dict[str, Any]) -> None:
        command = self._check_pending(data)
        if data.get("final"):
            self.told = Outcome.NOT_DONE
        if data["outcome"] == "done":
            self.pending = self.told = None
            self.stopped = max(self.stopped, data["stopped"] or 0.0)
            _DONE[command.name](self, command)

    def _check_pending(self, data: dict[str, Any]) -> Command:
        """Return the pending command, which an entry is about."""
        if self.pending is None or self.pending.id != data["command_id"]:
            raise JournalError(
                f"the journal tells the outcome of {data['command_id']}, which was not pending; it is damaged"
            )
        return self.pending

    def _passed(self, data: dict[str, Any]) -> None:
        """Go on where the belt stands: what went past the belt end unsorted is lost to the run."""
        if self.bin is not None:
            self.decisions.pop()  # it never reached its bin
        dealt_with = self.owed is Owed.ADVANCE and self.bin is None  # sorted or skipped
        self.passed += range(self.index + dealt_with, min(data["index"], self.end))
        self.pending = self.told = self.bin = None
        while self.index < min(data["index"], self.end):
            self._shift(self.index + 1)
        self.owed, self.arrived = Owed.CHOICE, False  # somebody was at the cell

    def _moved(self, command: Command) -> None:
        self.viewpoint, self.arrived = command.target, True
        if not command.arriving:
            self.steps += 1
            self.owed = Owed.SCAN

    def _sorted(self, _command: Command) -> None:
        self.bin = None

    def _advanced(self, command: Command) -> None:
        self._shift(command.target)
        looks = self.model.observe_after_decision and self.index < self.end
        self.owed = Owed.SCAN if looks else Owed.CHOICE

    def _shift(self, index: int) -> None:
        """Let the belt have moved on by one place."""
        self.index, self.glances = index, 0
        self.belief.advance()
        self.visible = [*self.visible[1:], Seen()]

    def _scan(self, data: dict[str, Any]) -> None:
        self.glances, self.strays = self.glances + 1, 0
        self.drift.see(self.belief, data["viewpoint"], data["labels"])
        self._believe(data)
        dropped = {drop["position"] for drop in data["dropped"]}
        for position, (seen, label) in enumerate(zip(self.visible, data["labels"], strict=True)):
            seen.looks += 1
            seen.empty = [*seen.empty, data["viewpoint"]] if data["empty"][position] else []
            if label is not None:
                seen.impossible = seen.impossible + 1 if position in dropped else 0
        self.owed = Owed.CHOICE

    def _believe(self, data: dict[str, Any]) -> None:
        self.belief = Belief(self.model, data["belief"], data["last_labels"], self.remaining)

    def _bad_scan(self, _data: dict[str, Any]) -> None:
        self.glances += 1

    def _wrong_viewpoint(self, _data: dict[str, Any]) -> None:
        self.glances += 1
        self.arrived, self.strays = False, self.strays + 1

    def _drift(self, _data: dict[str, Any]) -> None:
        self.drift.told += 1

    def _decision(self, data: dict[str, Any]) -> None:
        self.steps += 1
        self.decisions.append(
            Decision(self.index, data["label"], data["belief"], data["looks"], data["forced"])
        )
        self.bin, self.owed = data["bin"], Owed.ADVANCE

    def _skip(self, data: dict[str, Any]) -> None:
        self.steps += int(data["decided"])
        self.skipped.append(self.index)
        self.owed = Owed.ADVANCE

    def snapshot(self) -> dict[str, Any]:
        """Return everything but the model and what has left the belt, as plain data."""
        return {
            **{name: getattr(self, name) for name in _PLAIN},
            "belief": self.belief.probabilities.tolist(),
            "last_labels": self.belief.last_labels.tolist(),
            "owed": self.owed.value,
            "pending": None if self.pending is None else asdict(self.pending),
            "told": None if self.told is None else self.told.value,
            "visible": [asdict(seen) for seen in self.visible],
            "drift": self.drift.snapshot(),
        }

    def _snapshot(self, data: dict[str, Any]) -> None:
        for name in _PLAIN:
            setattr(self, name, data.get(name, getattr(self, name)))  # older files know fewer
        self._believe(data)
        self.owed = Owed(data["owed"])
        self.pending = None if data["pending"] is None else Command(**data["pending"])
        self.told = Outcome(data["told"]) if data.get("told") else None
        self.visible = [Seen(**seen) for seen in data["visible"]]
        if "drift" in data:
            self.drift = DriftState.of_snapshot(self.model, data["drift"])


_PLAIN = (
    *("run", "first", "objects", "belt_ends", "index", "viewpoint", "arrived"),
    *("steps", "commands", "glances", "strays", "stopped", "bin", "passed"),
)

_EFFECTS: dict[str, Callable[[Progress, dict[str, Any]], None]] = {
    "start": Progress._start,
    "resume": Progress._resume,
    "intent": Progress._intent,
    "outcome": Progress._outcome,
    "told": Progress._told,
    "passed": Progress._passed,
    "scan": Progress._scan,
    "bad_scan": Progress._bad_scan,
    "wrong_viewpoint": Progress._wrong_viewpoint,
    "drift": Progress._drift,
    "decision": Progress._decision,
    "skip": Progress._skip,
    "snapshot": Progress._snapshot,
}
"""Entries of other kinds change nothing."""

_DONE: dict[str, Callable[[Progress, Command], None]] = {
    "move": Progress._moved,
    "sort": Progress._sorted,
    "advance": Progress._advanced,
}
