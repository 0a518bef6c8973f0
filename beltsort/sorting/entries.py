"""The contents of journal entries: a closed set of frozen dataclasses.

An entry is stored as its `kind` and a JSON object of its fields, whose names are part of the file's format;
the format of a command is in `beltsort.sorting.entry_format`. A field whose default is None is omitted while
it is None; journals of older versions may lack any field that has a default. Times are seconds; objects are
numbers from 0; labels, bins and viewpoints are indices into the model's `labels`, `bins` and `viewpoints`,
the reject bin excepted; beliefs have shape (H, L).
"""

from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any, Literal, TypeAlias

from beltsort.sorting.command import Command
from beltsort.sorting.content import Content
from beltsort.sorting.holds import Answer, Way
from beltsort.sorting.moving.entries import MovingContent
from beltsort.sorting.report import Counts, Decision
from beltsort.sorting.rules import Seen


class State(StrEnum):
    """The state of a run, with the names of ISA-TR88.00.02 (PackML)."""

    EXECUTE = "Execute"
    COMPLETE = "Complete"
    HELD = "Held"
    """It continues once an operator has checked the cell, or has lifted the hold that one asked for."""
    STOPPED = "Stopped"
    """Ended by a person."""
    ABORTED = "Aborted"
    """Ended by the emergency stop, or by an unexpected error."""


@dataclass(frozen=True, kw_only=True)
class Started(Content):
    """The start of a run: the first entry. If `objects` is None, it goes on until it is told to stop."""

    kind = "start"
    run: str
    first: int = 0
    objects: int | None
    belt_ends: bool = False
    model: str
    """The model, as JSON."""
    planner: dict[str, Any] | None = None
    """Settings of `Despot`; None for another policy."""
    beltsort: str = ""
    """The version of beltsort that wrote the journal."""
    drift: dict[str, Any] | None = None
    """A `beltsort.sorting.rules.Drift` as plain data; None without drift detection."""


@dataclass(frozen=True, kw_only=True)
class Resumed(Content):
    """The run is resumed; fields as in `Started`."""

    kind = "resume"
    objects: int | None
    model: str
    planner: dict[str, Any] | None = None
    beltsort: str = ""
    drift: dict[str, Any] | None = None


@dataclass(frozen=True)
class StateChanged(Content):
    """The run is in another state; a held one may have `ways` to continue."""

    kind = "state"
    state: State
    reason: str
    command_id: str | None = None
    """Id of the command at which the run is held."""
    ways: list[Way] | None = None


@dataclass(frozen=True)
class Planned(Content):
    """`Despot` has chosen an action."""

    kind = "plan"
    action: dict[str, int]
    """`{"move": viewpoint}` or `{"decide": bin}`."""
    values: list[dict[str, Any]]
    """For every legal action, the action and its `value`."""
    lower: float
    upper: float
    trials: int
    seconds: float
    late: bool = False
    """Whether planning took much longer than its time budget."""


@dataclass(frozen=True)
class Chosen(Content):
    """Another policy has chosen an action, or a rule of the loop."""

    kind = "plan"
    action: dict[str, int]
    why: str | None = None
    """Why a rule chose; None if the policy did."""


@dataclass(frozen=True)
class Intended(Content):
    """A command is about to be sent."""

    kind = "intent"
    command: Command
    bin: str | None = None
    """Name of the bin of a sort; None for another act, and in journals of older versions."""
    number: int | None = None
    """The sorter's number of that bin."""


@dataclass(frozen=True)
class CommandDone(Content):
    """A command was carried out."""

    kind = "outcome"
    command_id: str
    outcome: Literal["done"] = "done"
    stopped: float | None = None
    """Time at which arm or belt came to a stop, on the cell's clock."""


@dataclass(frozen=True)
class CommandFailed(Content):
    """An attempt at a command failed."""

    kind = "outcome"
    command_id: str
    outcome: str
    """The outcome reported by the device, a value of `beltsort.cell.Outcome`."""
    error: str
    final: bool = False
    """Whether it is certain that the attempt never takes effect."""


@dataclass(frozen=True)
class Answered(Content):
    """An operator has said whether a command was done."""

    kind = "told"
    command_id: str
    outcome: str


@dataclass(frozen=True)
class Settled(Content):
    """A person has answered the open question from outside the process; `at` as in `Requested`."""

    kind = "settled"
    answer: Answer
    by: str
    at: str


@dataclass(frozen=True)
class ObjectsPassed(Content):
    """An operator has said that objects passed the belt end unsorted; the belt is at object `index`."""

    kind = "passed"
    index: int


@dataclass(frozen=True)
class Scanned(Content):
    """A scan, and the belief after it."""

    kind = "scan"
    viewpoint: int
    labels: list[int | None]
    """One per position, the belt end first; None where there was none."""
    empty: list[bool]
    findings: list[str]
    dropped: list[dict[str, Any]]
    """Labels that the belief held impossible: `position`, `label`, `probability`."""
    belief: list[list[float]]
    last_labels: list[list[int]]
    kinds: list[list[float]] | None = None
    """The belief over kinds, shape (H, N); None if every class has one mode."""
    pose_fault: str | None = None
    """What is likely wrong with the scan's pose; None if the belt is where it says."""


@dataclass(frozen=True)
class ScanUnusable(Content):
    """A scan that cannot be used."""

    kind = "bad_scan"
    error: str


@dataclass(frozen=True)
class ScanElsewhere(Content):
    """A scan from another viewpoint than the arm was sent to; it is dropped."""

    kind = "wrong_viewpoint"
    viewpoint: int
    stands_at: int | None
    """The viewpoint from which it was taken; None if it was from none."""
    angle: float
    """Degrees."""
    distance: float
    """Millimetres."""


@dataclass(frozen=True)
class Drifted(Content):
    """Drift detection has raised an alarm: a `beltsort.tables.Alarm`."""

    kind = "drift"
    position: int | None
    viewpoint: int | None
    looks: int
    evidence: float | None


@dataclass(frozen=True)
class Decided(Content):
    """The object at the belt end is to be sorted."""

    kind = "decision"
    label: int | None
    """The bin decided: that of a class, unless the model has `bins`; None if it is the reject bin."""
    bin: int
    """Index of the cell's bin: `label`, or the reject bin."""
    belief: float
    """Probability that the bin decided is right; for the reject bin, that the best one is."""
    looks: int
    forced: str | None
    """Why a rule decided; None if the policy did."""
    name: str | None = None
    """Name of the bin; None in journals of older versions."""
    true_class: int | None = None
    """Class index of the object, where the cell simulates it; None if it is not known."""


@dataclass(frozen=True)
class Skipped(Content):
    """The cup at the belt end is empty."""

    kind = "skip"
    viewpoints: list[int]
    """The viewpoints from which it was seen empty."""
    decided: bool


@dataclass(frozen=True)
class Requested(Content):
    """A person has asked to hold, continue or stop the run; as in `beltsort.sorting.requests.Request`."""

    kind = "request"
    action: Literal["hold", "continue", "stop"]
    by: str
    at: str


@dataclass(frozen=True)
class Unheard(Content):
    """A listener of the run failed and is not called again."""

    kind = "unheard"
    error: str


@dataclass(frozen=True, kw_only=True)
class Snapshot(Content):
    """The state of a run without the objects that have left the belt: the first entry of a further file.

    The fields are those of `beltsort.sorting.progress.Progress`; `decision` is the last one, if it is about
    the object at the belt end. Journals of older versions have no `counts`.
    """

    kind = "snapshot"
    model: str
    run: str
    first: int = 0
    objects: int | None
    belt_ends: bool = False
    index: int
    viewpoint: int
    arrived: bool
    steps: int
    commands: int
    scans: int
    missed_arrivals: int = 0
    stopped: float
    bin: int | None
    passed: list[int] = field(default_factory=list)
    belief: list[list[float]]
    last_labels: list[list[int]]
    kinds: list[list[float]] | None = None
    next: str
    pending: Command | None
    known_outcome: str | None = None
    settled: Answer | None = None
    visible: list[Seen]
    drift: dict[str, Any] | None = None
    pose_faults: dict[str, int] | None = None
    counts: Counts | None = None
    decision: Decision | None = None


@dataclass(frozen=True)
class Ended(Content):
    """The last entry of a run; missing after a kill or a power failure."""

    kind = "end"
    reason: str


AnyContent: TypeAlias = (
    Started
    | Resumed
    | StateChanged
    | Planned
    | Chosen
    | Intended
    | CommandDone
    | CommandFailed
    | Answered
    | Settled
    | ObjectsPassed
    | Scanned
    | ScanUnusable
    | ScanElsewhere
    | Drifted
    | Decided
    | Skipped
    | Requested
    | Unheard
    | Snapshot
    | Ended
    | MovingContent
)
