"""The report of a run."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from beltsort.tables import Alarm


@dataclass(frozen=True)
class Decision:
    """How one object was sorted.

    Attributes
    ----------
    object
        Its number on the belt, from 0.
    label
        The class decided; None if it went to the reject bin.
    belief
        Probability of the most likely class when it was decided.
    looks
        Scans in which it was visible.
    forced
        Why the loop decided in place of the policy: `max_looks` or `impossible_labels`; else None.
    """

    object: int
    label: int | None
    belief: float
    looks: int
    forced: str | None


@dataclass(frozen=True)
class SortingReport:
    """The decisions of a run, and the objects that were not sorted.

    Attributes
    ----------
    steps
        Planner steps: moves and decisions.
    decisions
        One per object sorted, in order.
    skipped
        Numbers of the cups found empty.
    drift
        Alarms of drift detection.
    passed
        Numbers of the objects that passed the belt end unsorted, according to the operator.
    """

    steps: int
    decisions: tuple[Decision, ...]
    skipped: tuple[int, ...]
    drift: "tuple[Alarm, ...]" = ()
    passed: tuple[int, ...] = ()
