"""Policies compared on the same objects."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from beltsort._core import (
    ArgumentError,
    Evaluation,
    SortingModel,
)
from beltsort.planning.bins import SortingStatistics, bins_table, sorting_statistics, sorts_into_classes
from beltsort.planning.difference import Difference, PairedStatistics, paired_difference
from beltsort.planning.display.comparison import comparison_html, comparison_latex, comparison_text
from beltsort.planning.display.comparison_plot import draw_differences
from beltsort.planning.frames import comparison_frame
from beltsort.planning.loss_bound import LossBound, loss_bounds_table
from beltsort.util.text import numbers_or_none

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

RETURNS = ("expected_discounted_returns", "discounted_returns")
"""What `Comparison.plot` shows if it is compared, the most precise first."""
BINS = (
    "Bins, per batch (purity: share of a bin's objects that belong there; recovery: share of the objects\n"
    "that belong there which arrived there):"
)


@dataclass(frozen=True, eq=False, repr=False)
class Comparison:
    """Policies evaluated on the same batches, and their differences; `repr` and `str` return a table.

    Attributes
    ----------
    model
        The model that updated the beliefs and gave the rewards.
    evaluations
        The evaluation of each policy, by name.
    baseline
        Name of the policy that the others are compared with.
    metrics
        Names of the compared properties of `Evaluation`.
    batch_size
        Decisions per batch.
    seed
        Seed of classes and labels.
    loss_bounds
        How much each policy loses at most, by name; empty without a reference, and for objects that are not
        drawn from the model.
    """

    model: SortingModel
    evaluations: Mapping[str, Evaluation]
    baseline: str
    metrics: tuple[str, ...]
    batch_size: int
    seed: int
    loss_bounds: Mapping[str, LossBound] = field(default_factory=dict)

    def outcomes(self, policy: str, metric: str) -> NDArray[np.float64]:
        """Return a metric of a policy for every batch, float64 of shape (batches,).

        Raises
        ------
        ArgumentError
            If the policy or the metric is unknown; the message lists the known ones.
        """
        check_known("policy", policy, list(self.evaluations))
        check_known("metric", metric, self.metrics)
        return np.asarray(getattr(self.evaluations[policy], metric), dtype=np.float64)

    def difference(self, policy: str, metric: str, other: str | None = None) -> Difference:
        """Return the mean difference of a metric between two policies.

        Batches are paired: both policies get the same objects, so the variance due to the objects cancels.

        Parameters
        ----------
        policy, other
            Names of policies; `other` defaults to the baseline.
        metric
            One of `metrics`.

        Returns
        -------
        Difference
            Mean over batches of `policy` minus `other`, with its standard error.

        Raises
        ------
        ArgumentError
            If a policy or the metric is unknown; the message lists the known ones.
        """
        reference = self.outcomes(self.baseline if other is None else other, metric)
        return paired_difference(self.outcomes(policy, metric), reference)

    def summary(self) -> dict[str, dict[str, dict[str, float]]]:
        """Return mean and standard error of each metric, ``[policy][metric]``."""
        summaries = {name: result.summary() for name, result in self.evaluations.items()}
        return {
            name: {metric: summary[metric] for metric in self.metrics} for name, summary in summaries.items()
        }

    def differences(self) -> dict[str, dict[str, Difference]]:
        """Return the differences of each policy from the baseline, ``[policy][metric]``."""
        return {
            name: {metric: self.difference(name, metric) for metric in self.metrics}
            for name in self.evaluations
            if name != self.baseline
        }

    def sorting(self) -> dict[str, SortingStatistics]:
        """Return what the decisions of each policy put into the bins, by policy."""
        return {name: sorting_statistics(self.model, result) for name, result in self.evaluations.items()}

    def to_dict(self) -> dict[str, Any]:
        """Return the comparison as plain data for JSON; numbers that are not finite become None."""
        return {
            "batches": len(self.evaluations[self.baseline].steps),
            "batch_size": self.batch_size,
            "seed": self.seed,
            "baseline": self.baseline,
            "summary": {
                name: {metric: numbers_or_none(statistics) for metric, statistics in summary.items()}
                for name, summary in self.summary().items()
            },
            "differences": {
                name: {
                    metric: numbers_or_none({"mean": d.mean, "standard_error": d.standard_error, "z": d.z})
                    for metric, d in differences.items()
                }
                for name, differences in self.differences().items()
            },
            "sorting": {name: statistics.to_dict() for name, statistics in self.sorting().items()},
            "loss_bounds": {name: bound.to_dict() for name, bound in self.loss_bounds.items()},
        }

    def __repr__(self) -> str:
        """Format means and paired differences as plain text, a row per metric; then bins, loss bounds."""
        return "\n".join([comparison_text(self._statistics()), *self._remarks()])

    def _repr_html_(self) -> str:
        """Return HTML for notebooks."""
        return comparison_html(self._statistics(), self._remarks())

    def plot(self, metric: str | None = None, ax: "Axes | None" = None) -> "Axes":
        """Draw the differences from the baseline, a row per policy, with 95 % confidence intervals.

        Filled points differ significantly from the baseline, hollow ones do not: their intervals contain 0.

        Parameters
        ----------
        metric
            One of `metrics`; default the discounted return, expected or realised, or else the first metric.
        ax
            Where to draw, `matplotlib.axes.Axes`; default a new figure of pyplot.

        Returns
        -------
        matplotlib.axes.Axes
            What was drawn on.

        Raises
        ------
        ArgumentError
            If the metric is unknown.
        MissingExtraError
            If matplotlib is not installed.
        """
        returns = [name for name in RETURNS if name in self.metrics]
        chosen = metric or [*returns, *self.metrics][0]
        check_known("metric", chosen, self.metrics)
        return draw_differences(self._statistics(), chosen, ax)

    def to_pandas(self) -> "pd.DataFrame":
        """Return means and differences as a table of pandas.

        Returns
        -------
        pandas.DataFrame
            A row per policy and metric, which are the levels of the index; the columns are `mean`,
            `standard_error`, and of the difference from the baseline `difference`,
            `difference_standard_error`, `z`. Differences of the baseline are NaN.

        Raises
        ------
        MissingExtraError
            If pandas is not installed.
        """
        return comparison_frame(self._statistics())

    def to_latex(self, metrics: Sequence[str] | None = None, *, label: str | None = None) -> str:
        """Return means and standard errors as a LaTeX table for the package booktabs.

        The caption tells how many batches there were and what is significant.

        Parameters
        ----------
        metrics
            The columns, some of `metrics`; default all.
        label
            Label to refer to the table by; default none.

        Returns
        -------
        str
            A `table` environment: a row per policy, a column per metric; an asterisk marks a significant
            difference from the baseline (5 %, two-sided, paired by batch).

        Raises
        ------
        ArgumentError
            If a metric is unknown.
        """
        for metric in metrics or ():
            check_known("metric", metric, self.metrics)
        return comparison_latex(self._statistics(), metrics or self.metrics, label)

    def _statistics(self) -> PairedStatistics:
        batches = len(self.evaluations[self.baseline].steps)
        return PairedStatistics(
            self.baseline, self.metrics, batches, self.batch_size, self.summary(), self.differences()
        )

    def _remarks(self) -> list[str]:
        """Return tables of bins and of loss bounds, where there are any."""
        bins = [] if sorts_into_classes(self.model) else [f"{BINS}\n{bins_table(self.sorting())}"]
        return [*bins, *([loss_bounds_table(self.loss_bounds)] if self.loss_bounds else [])]


def check_known(what: str, name: str, names: Sequence[str]) -> None:
    """Refuse a name that is not one of those given."""
    if name not in names:
        raise ArgumentError(f"there is no {what} {name!r}, expected one of {', '.join(names)}; choose one")
