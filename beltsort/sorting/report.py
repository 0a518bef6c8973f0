"""The report of a run."""

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

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
    pose_faults
        Number of scans by what is likely wrong with their pose, if anything.
    stopped_by
        Who asked to stop the run before all objects had left the belt; None if nobody did.
    """

    steps: int
    decisions: tuple[Decision, ...]
    skipped: tuple[int, ...]
    drift: "tuple[Alarm, ...]" = ()
    passed: tuple[int, ...] = ()
    pose_faults: Mapping[str, int] = field(default_factory=dict)
    stopped_by: str | None = None

    def counts(self, bins: Sequence[str]) -> dict[str, int]:
        """Return the number of objects in each of the model's bins that has any, `REJECTED` last.

        Parameters
        ----------
        bins
            Names of the model's bins.
        """
        names = [*bins, REJECTED]
        counts = Counter(names[-1 if d.label is None else d.label] for d in self.decisions)
        return {name: counts[name] for name in names if counts[name]}


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
