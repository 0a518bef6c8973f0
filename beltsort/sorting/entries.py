"""What the journal can tell: a closed set of frozen dataclasses.

An entry is kept as its `kind` and a JSON object of its fields, whose names are part of the file's format; a
command is kept as `beltsort.sorting.entry_format` says. A field whose default is None is left out while it
is None; journals of older versions may lack any field that has a default. Times are seconds; labels,
viewpoints and objects are numbers from 0; beliefs have shape (H, L).
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any, ClassVar, Literal, TypeAlias

from beltsort.sorting.command import Command
from beltsort.sorting.rules import Seen


class State(StrEnum):
    """Of a run, by the names of ISA-TR88.00.02 (PackML)."""

    EXECUTE = "Execute"
    COMPLETE = "Complete"
    HELD = "Held"
    """It goes on once somebody has seen to the cell."""
    STOPPED = "Stopped"
    """By a person."""
    ABORTED = "Aborted"
    """By the emergency stop, or by an error that nobody foresaw."""


class Content:
    """What an entry tells.

    Attributes
    ----------
    kind
        Its name in the journal; two forms of one entry share it.
    """

    kind: ClassVar[str]
    __pydantic_config__: ClassVar[Mapping[str, str]] = {"extra": "forbid"}


@dataclass(frozen=True, kw_only=True)
class Started(Content):
    """A run begins: the first entry."""

    kind = "start"
    run: str
    first: int = 0
    objects: int
    belt_ends: bool = False
    model: str
    """As JSON."""
    planner: dict[str, Any] | None = None
    """Settings of `Despot`; None for another policy."""
    beltsort: str = ""
    """Version that wrote it."""
    drift: dict[str, Any] | None = None
    """A `beltsort.sorting.rules.Drift` as plain data; None without a watch."""


@dataclass(frozen=True, kw_only=True)
class Resumed(Content):
    """A run goes on."""

    kind = "resume"
    objects: int
    model: str
    planner: dict[str, Any] | None = None
    beltsort: str = ""
    drift: dict[str, Any] | None = None


@dataclass(frozen=True)
class StateChanged(Content):
    """The run is in another state."""

    kind = "state"
    state: State
    reason: str
    command_id: str | None = None
    """Of the command at which it is held."""


@dataclass(frozen=True)
class Planned(Content):
    """`Despot` has chosen an action."""

    kind = "plan"
    action: dict[str, int]
    """`{"move": viewpoint}` or `{"decide": label}`."""
    values: list[dict[str, Any]]
    """Of every legal action: the action, and its `value`."""
    lower: float
    upper: float
    trials: int
    seconds: float
    late: bool = False
    """Whether it took much longer than it was given."""


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
    """The sorter's own number of that bin, which it is sent."""


@dataclass(frozen=True)
class CommandDone(Content):
    """A command was carried out."""

    kind = "outcome"
    command_id: str
    outcome: Literal["done"] = "done"
    stopped: float | None = None
    """When arm or belt stood still, on the cell's clock."""


@dataclass(frozen=True)
class CommandFailed(Content):
    """An attempt at a command failed."""

    kind = "outcome"
    command_id: str
    outcome: str
    """A `beltsort.cell.Outcome`'s value: what the device said."""
    error: str
    final: bool = False
    """Whether it is certain that the attempt never acts."""


@dataclass(frozen=True)
class Answered(Content):
    """A person has said whether a command was done."""

    kind = "told"
    command_id: str
    outcome: str


@dataclass(frozen=True)
class ObjectsPassed(Content):
    """A person has said that the belt went past objects; it stands at object `index`."""

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


@dataclass(frozen=True)
class ScanUnusable(Content):
    """A scan from which nothing can be read."""

    kind = "bad_scan"
    error: str


@dataclass(frozen=True)
class ScanElsewhere(Content):
    """A scan from another viewpoint than the arm was sent to; it is dropped."""

    kind = "wrong_viewpoint"
    viewpoint: int
    stands_at: int | None
    """The viewpoint at which it was taken, if it was at one."""
    angle: float
    """Degrees."""
    distance: float
    """Millimetres."""


@dataclass(frozen=True)
class Drifted(Content):
    """The watch over the tables has raised an alarm: a `beltsort.tables.Alarm`."""

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
    """None: it goes to the reject bin."""
    bin: int
    belief: float
    looks: int
    forced: str | None
    """Why a rule decided; None if the policy did."""


@dataclass(frozen=True)
class Skipped(Content):
    """The cup at the belt end is empty."""

    kind = "skip"
    viewpoints: list[int]
    """From which it was seen empty."""
    decided: bool


@dataclass(frozen=True)
class Unheard(Content):
    """A listener of the journal failed, and is not called any more."""

    kind = "unheard"
    error: str


@dataclass(frozen=True, kw_only=True)
class Snapshot(Content):
    """All of `Progress` but what has left the belt: a new file begins with it."""

    kind = "snapshot"
    model: str
    run: str
    first: int = 0
    objects: int
    belt_ends: bool = False
    index: int
    viewpoint: int
    arrived: bool
    steps: int
    commands: int
    glances: int
    strays: int = 0
    stopped: float
    bin: int | None
    passed: list[int] = field(default_factory=list)
    belief: list[list[float]]
    last_labels: list[list[int]]
    owed: str
    pending: Command | None
    told: str | None = None
    visible: list[Seen]
    drift: dict[str, Any] | None = None


@dataclass(frozen=True)
class Ended(Content):
    """The run's last entry; after a kill or a power cut there is none."""

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
    | ObjectsPassed
    | Scanned
    | ScanUnusable
    | ScanElsewhere
    | Drifted
    | Decided
    | Skipped
    | Unheard
    | Snapshot
    | Ended
)
