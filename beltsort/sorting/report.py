"""The report of a run."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import NDArray

from beltsort._core import SortingModel

if TYPE_CHECKING:
    from beltsort.tables import Alarm

REJECTED = "rejected"
"""Stands for the reject bin in counts of objects per bin."""


@dataclass(frozen=True)
class Decision:
    """How one object was sorted.

    Attributes
    ----------
    object
        Its number on the belt, from 0.
    label
        Index into `model.bins`: the class decided, unless the model names bins; None if it went to the reject
        bin.
    belief
        Probability, when it was decided, that this bin is right; for the reject bin, that the best one is.
    looks
        Scans in which it was visible.
    forced
        Why the loop decided in place of the policy: `max_looks` or `impossible_labels`; else None.
    true_class
        Its class index, where the cell simulates it; None if it is not known.
    """

    object: int
    label: int | None
    belief: float
    looks: int
    forced: str | None
    true_class: int | None = None


@dataclass(frozen=True)
class Counts:
    """Numbers of objects that have left the belt end: all that grows in a run without a fixed end.

    Attributes
    ----------
    bins
        Decisions for each of the model's B bins, and for the reject bin, the last.
    skipped, passed
        Empty cups, and objects that passed the belt end unsorted.
    forced
        Decisions that a rule has forced.
    confusion
        Decisions by bin and true class, shape (B, L), where the cell simulates the objects; otherwise, and
        before the first of them, None. Objects in the reject bin are left out.
    """

    bins: tuple[int, ...]
    skipped: int = 0
    passed: int = 0
    forced: int = 0
    confusion: tuple[tuple[int, ...], ...] | None = None

    @classmethod
    def none(cls, model: SortingModel) -> Self:
        """Return the counts before the first object."""
        return cls((0,) * (len(model.bins) + 1))

    @property
    def sorted(self) -> int:
        """Number of decisions."""
        return sum(self.bins)

    def with_decision(self, decision: Decision, model: SortingModel, number: int = 1) -> "Counts":
        """Return the counts after a decision, or with -1 as `number`, without one that was counted."""
        place = len(self.bins) - 1 if decision.label is None else decision.label
        confusion = self.confusion
        if decision.true_class is not None and decision.label is not None:
            table = np.array(confusion or np.zeros((len(model.bins), len(model.classes)), dtype=np.int64))
            table[decision.label, decision.true_class] += number
            confusion = tuple(map(tuple, table.tolist()))
        return replace(
            self,
            bins=(*self.bins[:place], self.bins[place] + number, *self.bins[place + 1 :]),
            forced=self.forced + number * (decision.forced is not None),
            confusion=confusion,
        )

    def added(self, other: "Counts") -> "Counts":
        """Return the sum of these counts and those of other objects, whose true classes are not known."""
        return replace(
            self,
            bins=tuple(map(sum, zip(self.bins, other.bins, strict=True))),
            skipped=self.skipped + other.skipped,
            passed=self.passed + other.passed,
            forced=self.forced + other.forced,
        )

    def by_bin(self, bins: Sequence[str]) -> dict[str, int]:
        """Return the number of decisions for each bin that has any, `REJECTED` last.

        Parameters
        ----------
        bins
            Names of the model's bins.
        """
        return {name: count for name, count in zip([*bins, REJECTED], self.bins, strict=True) if count}


@dataclass(frozen=True)
class SortingReport:
    """The decisions of a run, and the objects that were not sorted.

    Attributes
    ----------
    steps
        Planner steps: moves and decisions.
    decisions
        One per object sorted, in order; the latest 1000.
    skipped
        Numbers of the cups found empty; the latest 1000.
    drift
        Alarms of drift detection.
    passed
        Numbers of the objects that passed the belt end unsorted, according to the operator; the latest 1000.
    counts
        How many objects there were of each, from the start of the run.
    pose_faults
        Number of scans by what is likely wrong with their pose, if anything.
    stopped_by
        Who asked to stop the run before all objects had left the belt; None if nobody did.
    """

    steps: int
    decisions: tuple[Decision, ...]
    skipped: tuple[int, ...]
    counts: Counts
    drift: "tuple[Alarm, ...]" = ()
    passed: tuple[int, ...] = ()
    pose_faults: Mapping[str, int] = field(default_factory=dict)
    stopped_by: str | None = None


def confusion(
    decisions: Iterable[tuple[int, int | None]],
    true_class: Callable[[int], int | None],
    model: SortingModel,
) -> NDArray[np.uint64]:
    """Count decisions by bin and true class.

    Parameters
    ----------
    decisions
        Number of the object, and index of its bin, or None for the reject bin, of each.
    true_class
        Returns the class index of an object, or None for an empty cup.
    model
        The model, with L classes and B bins.

    Returns
    -------
    numpy.ndarray
        uint64 of shape (B, L), like `Evaluation.confusion` of one batch. Objects in the reject bin and empty
        cups are left out.

    Examples
    --------
    >>> import beltsort
    >>> model = beltsort.SortingModel(["nut", "bolt"], ["front"], [[[[0.8, 0.2], [0.2, 0.8]]]])
    >>> confusion([(0, 1), (1, 1), (2, None)], [1, 0, 1].__getitem__, model).tolist()
    [[0, 0], [1, 1]]
    """
    counts = np.zeros((len(model.bins), len(model.classes)), dtype=np.uint64)
    for number, bin in decisions:
        true = true_class(number)
        if bin is not None and true is not None:
            counts[bin, true] += np.uint64(1)
    return counts
