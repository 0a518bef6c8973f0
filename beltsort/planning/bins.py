"""Which classes belong into which bin, and statistics of what simulated decisions put there."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from beltsort._core import Evaluation, SortingModel
from beltsort.planning.decisions import right_bins
from beltsort.util.text import number_or_none, numbers_or_none, text_table

Floats = NDArray[np.float64]
Counts = NDArray[np.uint64]


@dataclass(frozen=True)
class Estimate:
    """A number estimated from batches.

    Attributes
    ----------
    value
        The estimate; NaN where it is not defined.
    standard_error
        Its standard error over batches; NaN for a single batch, and where the estimate is not defined.
    """

    value: float
    standard_error: float

    def to_dict(self) -> dict[str, float | None]:
        """Return the numbers as plain data for JSON; those that are not finite become None."""
        return numbers_or_none({"value": self.value, "standard_error": self.standard_error})

    def __str__(self) -> str:
        """Format as `value ± standard error`, or without an error that is not defined."""
        if math.isnan(self.value):
            return "-"
        error = "" if math.isnan(self.standard_error) else f" ± {self.standard_error:.3f}"
        return f"{self.value:.3f}{error}"


@dataclass(frozen=True)
class BinStatistics:
    """What one bin received.

    Attributes
    ----------
    name
        The bin's name.
    objects
        Objects per batch.
    purity
        Share of the bin's objects that belong there; NaN if it received none, and for a bin where no class
        belongs, such as a manual bin.
    recovery
        Share of the objects that belong there which arrived there; NaN where none belongs.
    """

    name: str
    objects: Estimate
    purity: Estimate
    recovery: Estimate


@dataclass(frozen=True, eq=False)
class SortingStatistics:
    """Right decisions, their rewards, and objects by bin and class, of simulated batches.

    Attributes
    ----------
    classes
        Names of the L classes.
    right
        Right decisions per batch, that is into a bin where the object belongs.
    reward
        Reward of the decisions per batch, without the costs of moves.
    confusion
        Objects per batch by bin and class, float64 of shape (B, L).
    confusion_errors
        Standard errors of `confusion`; NaN for a single batch.
    bins
        Statistics of each of the B bins.
    """

    classes: tuple[str, ...]
    right: Estimate
    reward: Estimate
    confusion: Floats
    confusion_errors: Floats
    bins: tuple[BinStatistics, ...]

    def to_dict(self) -> dict[str, Any]:
        """Return the statistics as plain data for JSON; numbers that are not finite become None."""
        return {
            "classes": list(self.classes),
            "bins": [found.name for found in self.bins],
            "right": self.right.to_dict(),
            "reward": self.reward.to_dict(),
            "confusion": {
                "value": self.confusion.tolist(),
                "standard_error": [[*map(number_or_none, row)] for row in self.confusion_errors.tolist()],
            },
            "objects": {found.name: found.objects.to_dict() for found in self.bins},
            "purity": {found.name: found.purity.to_dict() for found in self.bins},
            "recovery": {found.name: found.recovery.to_dict() for found in self.bins},
        }

    def __repr__(self) -> str:
        """Return what `str` does."""
        return str(self)

    def __str__(self) -> str:
        """Format the confusion of classes by bins as plain text, a row per bin."""
        digits = 0 if np.isnan(self.confusion_errors).all() else 3
        rows = [
            [found.name, *(f"{n:.{digits}f}" for n in counts), str(found.purity), str(found.recovery)]
            for found, counts in zip(self.bins, self.confusion.tolist(), strict=True)
        ]
        return text_table([["bin", *self.classes, "purity", "recovery"], *rows])


def sorts_into_classes(model: SortingModel) -> bool:
    """Return whether decisions are the paper's: a bin per class, right or wrong."""
    paper = np.where(np.eye(len(model.classes), dtype=bool), model.r_max, -model.r_min)
    return model.bins == model.classes and np.array_equal(model.reward, paper)


def sorting_statistics(model: SortingModel, evaluation: Evaluation | Counts) -> SortingStatistics:
    """Return what the decisions of simulated batches, or of a run, put into the bins.

    Purity and recovery are ratios of totals over all batches; their standard errors are those of ratio
    estimators, to first order in the deviations of both totals.

    Parameters
    ----------
    model
        The model that the batches were evaluated with.
    evaluation
        The outcome of `evaluate`, or the objects of one run by bin and class, uint64 of shape (B, L), as
        `beltsort.sorting.report.confusion` returns them.

    References
    ----------
    Cochran, "Sampling Techniques", 3rd edition, 1977, section 6.3 (standard error of a ratio).
    """
    counts = evaluation.confusion if isinstance(evaluation, Evaluation) else evaluation[None]
    confusion = counts.astype(np.float64)  # (batches, B, L)
    right = right_bins(model)
    return SortingStatistics(
        classes=tuple(model.classes),
        right=mean_of((confusion * right).sum(axis=(1, 2))),
        reward=mean_of((confusion * model.reward).sum(axis=(1, 2))),
        confusion=confusion.mean(axis=0),
        confusion_errors=_standard_errors(confusion),
        bins=bin_statistics(model, confusion, confusion.sum(axis=1)),
    )


def bin_statistics(model: SortingModel, confusion: Floats, arrived_of: Floats) -> tuple[BinStatistics, ...]:
    """Return what every bin received.

    Parameters
    ----------
    model
        Names the bins and says what belongs where.
    confusion
        Objects by bin and class in each batch, float64 of shape (batches, B, L).
    arrived_of
        Objects of each class in each batch, those that came to no bin included, float64 of shape
        (batches, L).
    """
    right = right_bins(model)
    in_bin = confusion.sum(axis=2)  # (batches, B)
    arrived = (confusion * right).sum(axis=2)  # (batches, B), of the objects that belong there
    belonging = arrived_of @ right.T  # (batches, B)
    return tuple(
        BinStatistics(
            name,
            objects=mean_of(in_bin[:, b]),
            purity=ratio_of(arrived[:, b], in_bin[:, b]) if right[b].any() else Estimate(math.nan, math.nan),
            recovery=ratio_of(arrived[:, b], belonging[:, b]),
        )
        for b, name in enumerate(model.bins)
    )


def bins_table(statistics: Mapping[str, SortingStatistics]) -> str:
    """Format rewards, purity and recovery as plain text, a column per policy."""
    policies = list(statistics.values())
    rows = [["reward of decisions", *(str(found.reward) for found in policies)]]
    for columns in zip(*(found.bins for found in policies), strict=True):
        name = columns[0].name
        rows += [
            [f"{name}: objects", *(str(found.objects) for found in columns)],
            [f"{name}: purity", *(str(found.purity) for found in columns)],
            [f"{name}: recovery", *(str(found.recovery) for found in columns)],
        ]
    return text_table([["", *statistics], *rows])


def mean_of(sample: Floats) -> Estimate:
    """Estimate a mean from a sample of shape (batches,)."""
    return Estimate(float(sample.mean()), float(_standard_errors(sample)))


def ratio_of(numerator: Floats, denominator: Floats) -> Estimate:
    """Estimate E[numerator] / E[denominator] from pairs, one per batch; NaN if the denominators are 0."""
    total = float(denominator.sum())
    if total == 0.0:
        return Estimate(math.nan, math.nan)
    ratio = float(numerator.sum()) / total
    residuals = numerator - ratio * denominator
    return Estimate(ratio, float(_standard_errors(residuals)) / float(denominator.mean()))


def _standard_errors(sample: Floats) -> Floats:
    """Return standard errors of means over the first axis; NaN for a single batch."""
    n = len(sample)
    if n == 1:
        return np.full(sample.shape[1:], math.nan)
    return np.asarray(sample.std(axis=0, ddof=1) / math.sqrt(n))
