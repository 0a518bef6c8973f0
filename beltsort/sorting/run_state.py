"""What is known of a run at some time, and its form in the journal."""

import sys
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import TypeVar

from beltsort._core import Belief, SortingModel
from beltsort.cell.commands import Outcome
from beltsort.sorting.command import Command
from beltsort.sorting.drift_state import DriftState
from beltsort.sorting.entries import Snapshot
from beltsort.sorting.entry_format import plain_belief
from beltsort.sorting.holds import Answer
from beltsort.sorting.report import Counts, Decision
from beltsort.sorting.rules import Seen

LATEST = 1000
"""Number of the latest decisions, empty cups and passed objects that a run remembers one by one."""

Kept = TypeVar("Kept")


NO_COUNTS = Counts(())


class Next(Enum):
    """The next thing that the loop does, unless a command is pending."""

    CHOOSE = "choice"
    """Choose an action."""
    SCAN = "scan"
    """Scan from the current viewpoint."""
    ADVANCE = "advance"
    """Bring the next object to the belt end."""


@dataclass
class RunState:
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
    counts
        Numbers of decisions, empty cups and objects that passed the belt end unsorted, from the start.
    decisions, skipped, passed
        The latest decisions, and the numbers of the latest objects that were skipped or passed the belt end
        unsorted: at most `keep` of each.
    keep
        See there; None: all, which in a run without a fixed end grow without bound.
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
    counts: Counts = NO_COUNTS
    decisions: list[Decision] = field(default_factory=list)
    skipped: list[int] = field(default_factory=list)
    passed: list[int] = field(default_factory=list)
    keep: int | None = LATEST

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

    def keep_latest(self, latest: list[Kept], further: Iterable[Kept]) -> None:
        """Add to a list, and drop what is too old."""
        latest += further
        if self.keep is not None:
            del latest[: -self.keep]

    def snapshot(self) -> Snapshot:
        """Return the state without the objects that have left the belt."""
        return Snapshot(
            **{name: getattr(self, name) for name in _SAME_NAME},
            counts=self.counts,
            model=self.model.to_json(),
            next=self.next.value,
            known_outcome=None if self.known_outcome is None else self.known_outcome.value,
            passed=list(self.passed),
            **plain_belief(self.belief),
            visible=[replace(seen) for seen in self.visible],
            drift=self.drift.snapshot(),
            pose_faults=dict(self.pose_faults) or None,
            decision=next((d for d in self.decisions[-1:] if d.object == self.index), None),
        )

    def restore(self, snapshot: Snapshot) -> None:
        """Take over the state that a snapshot holds; what it lacks stays as it is."""
        for name in _SAME_NAME:
            setattr(self, name, getattr(snapshot, name))
        self.next = Next(snapshot.next)
        outcome = snapshot.known_outcome
        self.known_outcome = None if outcome is None else Outcome(outcome)
        if snapshot.counts is None:  # of an older version: the rest is in earlier entries
            self.counts = replace(self.counts, passed=len(snapshot.passed))
        else:
            self.counts = snapshot.counts
        if snapshot.decision is not None and snapshot.decision not in self.decisions[-1:]:
            self.keep_latest(self.decisions, [snapshot.decision])
        kinds = snapshot.kinds or snapshot.belief
        self.belief = Belief(self.model, kinds, snapshot.last_labels, self.remaining)
        self.visible = [replace(seen) for seen in snapshot.visible]
        self.passed = list(snapshot.passed)
        self.pose_faults = dict(snapshot.pose_faults or {})
        if snapshot.drift is not None:
            self.drift = DriftState.of_snapshot(self.model, snapshot.drift)


_SAME_NAME = (
    *("run", "first", "objects", "belt_ends", "index", "viewpoint", "arrived", "steps", "commands"),
    *("scans", "missed_arrivals", "stopped", "bin", "pending", "settled"),
)
"""Attributes that a snapshot stores under the same name."""
