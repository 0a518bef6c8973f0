"""Statistics of simulated runs of a moving belt."""

import math
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from beltsort._core import MovingBelt
from beltsort.planning.bins import BinStatistics, Counts, Estimate, Floats, bin_statistics, mean_of, ratio_of
from beltsort.util.text import text_table


class MovingRuns(Protocol):
    """Outcomes of runs on a moving belt, arrays of shape (runs,): a `MovingEvaluation`, or runs of a cell."""

    @property
    def belt(self) -> MovingBelt:
        """The belt."""

    @property
    def objects(self) -> int | Counts:
        """Objects of each run."""

    @property
    def ticks(self) -> Counts | Floats:
        """Ticks of each run."""

    @property
    def looks(self) -> Counts:
        """Looks at undecided objects; a scan of two of them counts twice."""

    @property
    def right(self) -> Counts:
        """Decisions into a bin than which none is worth more for the object's class."""

    @property
    def wrong(self) -> Counts:
        """Other decisions."""

    @property
    def missed(self) -> Counts:
        """Objects that passed the exit undecided, by true class, shape (runs, L)."""

    @property
    def confusion(self) -> Counts:
        """Decided objects by bin and true class, shape (runs, B, L)."""

    @property
    def returns(self) -> Floats:
        """Sum of rewards."""

    @property
    def discounted_returns(self) -> Floats | None:
        """Sum of rewards, each discounted from its tick; None if their ticks are not known."""


@dataclass(frozen=True)
class MovingStatistics:
    """What a policy achieves on a moving belt: estimates over runs, each with its standard error.

    Attributes
    ----------
    reward_per_object
        Sum of rewards, missed objects and moves included, by the number of objects.
    discounted_return
        Sum of rewards, each discounted from its tick; None of runs of a cell.
    right, wrong, missed
        Shares of the objects: decided into a bin where they belong, into another one, and not decided before
        they passed the exit.
    looks_per_object
        Looks, a scan of two undecided objects counting twice, by the number of objects.
    ticks
        Ticks of a run.
    objects_per_minute
        Decided objects in a minute; None if the belt has no `seconds_per_tick`.
    bins
        Of each of the B bins its objects per run, purity and recovery; missed objects count against recovery.
    """

    reward_per_object: Estimate
    discounted_return: Estimate | None
    right: Estimate
    wrong: Estimate
    missed: Estimate
    looks_per_object: Estimate
    ticks: Estimate
    objects_per_minute: Estimate | None
    bins: tuple[BinStatistics, ...]

    @property
    def least_purity(self) -> Estimate:
        """Purity of the bin that has the least; NaN if no bin has one."""
        purities = [found.purity for found in self.bins if not math.isnan(found.purity.value)]
        return min(purities, key=lambda purity: purity.value, default=Estimate(math.nan, math.nan))

    def estimates(self) -> dict[str, Estimate]:
        """Return all estimates but those of bins by name, those that are None left out."""
        found = {name: value for name, value in vars(self).items() if isinstance(value, Estimate)}
        return {**found, "least_purity": self.least_purity}

    def to_dict(self) -> dict[str, Any]:
        """Return the statistics as plain data for JSON; numbers that are not finite become None."""
        return {
            **{name: value.to_dict() for name, value in self.estimates().items()},
            "purity": {found.name: found.purity.to_dict() for found in self.bins},
            "recovery": {found.name: found.recovery.to_dict() for found in self.bins},
        }

    def __str__(self) -> str:
        """Format as plain text, a row per estimate."""
        rows = [[name.replace("_", " "), str(value)] for name, value in self.estimates().items()]
        rows += [[f"{found.name}: purity", str(found.purity)] for found in self.bins]
        return text_table(rows)


def moving_statistics(evaluation: MovingRuns) -> MovingStatistics:
    """Return the statistics of simulated runs.

    Objects per minute and purities are ratios of totals over all runs, with the standard errors of ratio
    estimators (Cochran, "Sampling Techniques", 3rd edition, 1977, section 6.3).
    """
    belt, objects = evaluation.belt, evaluation.objects
    discounted = evaluation.discounted_returns
    confusion = evaluation.confusion.astype(np.float64)
    missed = evaluation.missed.astype(np.float64)
    ticks = evaluation.ticks.astype(np.float64)
    per_minute = None
    if belt.seconds_per_tick is not None:
        per_minute = ratio_of(confusion.sum(axis=(1, 2)), ticks * belt.seconds_per_tick / 60)
    return MovingStatistics(
        reward_per_object=mean_of(evaluation.returns / objects),
        discounted_return=None if discounted is None else mean_of(discounted),
        right=mean_of(evaluation.right / objects),
        wrong=mean_of(evaluation.wrong / objects),
        missed=mean_of(missed.sum(axis=1) / objects),
        looks_per_object=mean_of(evaluation.looks / objects),
        ticks=mean_of(ticks),
        objects_per_minute=per_minute,
        bins=bin_statistics(belt.model, confusion, confusion.sum(axis=1) + missed),
    )
