"""The contents of journal entries that only a run on a belt that never stops has.

Coordinates are metres of the belt's travel: an object's is the travel when it passes the belt end (x = 0). It
does not change, and holds for one start of the controller, which `boot_id` names. Stamps are seconds on the
cell's clock.
"""

from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any, TypeAlias

from beltsort.sorting.content import Content


class Fate(StrEnum):
    """How an object has left the belt."""

    IN_BIN = "in bin"
    EMPTY = "empty"
    """Its cup was empty."""
    MISSED = "missed"
    """It passed the belt end undecided, and went to the overflow."""
    TOO_LATE = "too late"
    """Its diversion came too late, and it went to the overflow."""
    NOT_DONE = "not done"
    """Its diversion was refused or not carried out, and it went to the overflow."""
    UNKNOWN = "unknown"
    """The controller was restarted after its diversion was queued: it is in that bin, in the overflow, or
    still on the belt, where it gets another number."""
    LOST = "lost"
    """The controller was restarted while it was undecided; on the belt it gets another number."""


@dataclass(frozen=True, kw_only=True)
class MovingStarted(Content):
    """The start of a run: the first entry. If `objects` is None, it goes on until it is told to stop."""

    kind = "moving_start"
    run: str
    objects: int | None
    belt: str
    """The `beltsort.MovingBelt`, model included, as JSON."""
    beltsort: str = ""
    """The version of beltsort that wrote the journal."""


@dataclass(frozen=True, kw_only=True)
class MovingResumed(Content):
    """The run is resumed; fields as in `MovingStarted`."""

    kind = "moving_resume"
    belt: str
    beltsort: str = ""


@dataclass(frozen=True)
class Anchored(Content):
    """Where objects stand on the belt: object `first` at `origin`, each further one a spacing behind."""

    kind = "anchor"
    boot_id: str
    spacing: float
    origin: float
    first: int
    uncounted: int = 0
    """Most objects that may have passed without a number, if the belt did not stop: under the controller's
    start before this one, after the last scan."""


@dataclass(frozen=True)
class SeenObject:
    """What a scan showed of one object."""

    number: int
    coordinate: float | None
    """None if it was expected there, and its place was not measured."""
    label: int | None
    """Index of the model's label; None if there was none, or if it was impossible under the belief."""
    finding: str
    kinds: list[float] | None = None
    """Distribution of its kind after the scan, length N; None if it has not changed."""
    dropped: int | None = None
    """A label that the belief held impossible."""


@dataclass(frozen=True)
class Looked(Content):
    """A scan of the moving belt."""

    kind = "look"
    viewpoint: int
    stamp: float
    """The middle of the exposure."""
    travel: float
    seen: list[SeenObject]
    events: list[str] = field(default_factory=list)
    """What was doubtful about the tracks."""


@dataclass(frozen=True)
class Diverting(Content):
    """A diversion is about to be sent: the decision about an object."""

    kind = "divert"
    command_id: str
    number: int
    coordinate: float
    bin: int
    """Index of the bin."""
    name: str
    """Name of the bin."""
    boot_id: str
    belief: float
    """Probability that the bin is right."""
    looks: int
    true_class: int | None = None
    """Class index of the object, where the cell simulates it; None if it is not known."""


@dataclass(frozen=True)
class FoundEmpty(Content):
    """The decision that a cup is empty, of a model with a class for empty cups."""

    kind = "found_empty"
    number: int
    belief: float
    """Probability that it is."""
    looks: int


@dataclass(frozen=True)
class DiversionTold(Content):
    """What the controller says of a diversion, whenever it is something new."""

    kind = "diversion"
    command_id: str
    number: int
    state: str
    """A value of `beltsort.cell.Diversion`."""
    reason: str = ""
    retry: bool = False
    """Whether it may be sent again."""


@dataclass(frozen=True)
class EncoderJumped(Content):
    """The belt's encoder jumped: coordinates of this start of the controller, and its queue, are void."""

    kind = "jump"
    boot_id: str
    reason: str


@dataclass(frozen=True)
class ObjectLeft(Content):
    """An object has left the belt: the last entry about it."""

    kind = "left"
    number: int
    fate: Fate
    reason: str = ""


@dataclass(frozen=True)
class BeltObject:
    """What is known of an object on the belt.

    Attributes
    ----------
    kinds
        Distribution of its kind, length N.
    coordinate
        The last one measured; None before.
    looks
        Number of labels.
    empty
        Number of scans in a row that showed its cup empty.
    command_id, bin
        Its diversion and the index of its bin, once it is decided.
    true_class
        Its class index, where the cell simulates it; None if it is not known, or not decided.
    state, retry
        What the controller has said of the diversion, as in `DiversionTold`; None before it was told.
    skipped
        Whether its cup was decided to be empty.
    """

    kinds: list[float]
    coordinate: float | None = None
    looks: int = 0
    empty: int = 0
    command_id: str | None = None
    bin: int | None = None
    true_class: int | None = None
    state: str | None = None
    retry: bool = False
    skipped: bool = False

    @property
    def decided(self) -> bool:
        """Whether it is decided."""
        return self.skipped or self.command_id is not None


@dataclass(frozen=True, kw_only=True)
class MovingSnapshot(Content):
    """The state of a run without the objects that have left: the first entry of a further file."""

    kind = "moving_snapshot"
    run: str
    objects: int | None
    belt: str
    anchor: dict[str, Any] | None
    """The fields of `Anchored`."""
    viewpoint: int
    commands: int
    scans: int
    settled: int
    """Every object with a smaller number is decided or has left."""
    on_belt: dict[str, BeltObject]
    """By number."""
    fates: dict[str, int]
    bins: list[int]
    confusion: list[list[int]]
    uncounted: int = 0
    watched: float | None = None
    watched_exit: int = 0
    jumped: str = ""
    """The start of the controller in which the encoder jumped."""


MovingContent: TypeAlias = (
    MovingStarted
    | MovingResumed
    | Anchored
    | Looked
    | Diverting
    | FoundEmpty
    | DiversionTold
    | EncoderJumped
    | ObjectLeft
    | MovingSnapshot
)
