"""Policies compared on the same objects."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from beltsort._core import (
    DEFAULT_BATCH_SIZE,
    DEFAULT_BATCHES,
    DEFAULT_MAX_LOOKS,
    ArgumentError,
    Evaluation,
    Solution,
    SortingModel,
    evaluate,
)
from beltsort.planning.bins import SortingStatistics, bins_table, sorting_statistics, sorts_into_classes
from beltsort.planning.loss_bound import LossBound, loss_bound, loss_bounds_table
from beltsort.planning.policy import Policy
from beltsort.util.text import numbers_or_none, text_table

BINS = (
    "Bins, per batch (purity: share of a bin's objects that belong there; recovery: share of the objects\n"
    "that belong there which arrived there):"
)


@dataclass(frozen=True)
class Difference:
    """A mean difference over paired batches.

    Attributes
    ----------
    mean
        Sample mean of the differences.
    standard_error
        Standard error of that mean; NaN for a single batch.
    """

    mean: float
    standard_error: float

    @property
    def z(self) -> float:
        """The mean divided by its standard error; a magnitude above 2 is unlikely to be due to chance."""
        if self.standard_error == 0:
            return math.copysign(math.inf, self.mean) if self.mean else 0.0
        return self.mean / self.standard_error


@dataclass(frozen=True, eq=False)
class Comparison:
    """Policies evaluated on the same batches, and their differences; `str` returns a table.

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
        _check("policy", policy, list(self.evaluations))
        _check("metric", metric, self.metrics)
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
        differences = self.outcomes(policy, metric) - reference
        n = len(differences)
        error = float(differences.std(ddof=1)) / math.sqrt(n) if n > 1 else math.nan
        return Difference(float(differences.mean()), error)

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

    def __str__(self) -> str:
        """Format means and paired differences as plain text, a row per metric; then bins, loss bounds."""
        batches = len(self.evaluations[self.baseline].steps)
        means = {
            name: [f"{s['mean']:.3f} ± {s['standard_error']:.3f}" for s in summary.values()]
            for name, summary in self.summary().items()
        }
        against = {
            name: [f"{d.mean:+.3f} ± {d.standard_error:.3f} ({d.z:+.1f})" for d in differences.values()]
            for name, differences in self.differences().items()
        }
        return "\n".join(
            [
                f"Per batch of {self.batch_size}, mean ± standard error over {batches}:",
                self._table(means),
                f"Minus {self.baseline} in the same batches, mean ± standard error (z):",
                self._table(against),
                *([] if sorts_into_classes(self.model) else [BINS, bins_table(self.sorting())]),
                *([loss_bounds_table(self.loss_bounds)] if self.loss_bounds else []),
            ]
        )

    def _table(self, columns: Mapping[str, Sequence[str]]) -> str:
        cells = zip(*columns.values(), strict=True)
        rows = [[metric.replace("_", " "), *row] for metric, row in zip(self.metrics, cells, strict=True)]
        return text_table([["", *columns], *rows])


def compare(
    model: SortingModel,
    policies: Mapping[str, Policy],
    *,
    batches: int = DEFAULT_BATCHES,
    batch_size: int = DEFAULT_BATCH_SIZE,
    seed: int = 0,
    threads: int | None = None,
    viewpoint: int | str = 0,
    true_classes: ArrayLike | None = None,
    truth: SortingModel | None = None,
    max_looks: int = DEFAULT_MAX_LOOKS,
    reference: Solution | None = None,
    belt_ends: bool = False,
    baseline: str | None = None,
    metrics: Sequence[str] | None = None,
) -> Comparison:
    """Evaluate policies on the same batches.

    Random numbers are indexed by (batch, object, look), so that every policy gets the same objects. Paired
    differences have much smaller standard errors than differences of means. Tune a baseline on other seeds
    than those of the comparison.

    Parameters
    ----------
    model, batches, batch_size, seed, threads, viewpoint, true_classes, truth, max_looks, belt_ends
        As in `evaluate`.
    reference
        A solution of the model, of any size. With it, the comparison tells how much each policy loses at most
        (`Comparison.loss_bounds`), on objects drawn from the model; make batches long enough for the rewards
        after them not to count. If it values actions, regrets are compared as well, as in `evaluate`.
    policies
        At least two policies, by name.
    baseline
        Name of the policy that the others are compared with; default the first.
    metrics
        Names of properties of `Evaluation` to compare; default all that are unbiased. With many metrics, some
        differ significantly by chance.

    Returns
    -------
    Comparison
        The evaluation of every policy, with means and paired differences.

    Raises
    ------
    ArgumentError
        If there are fewer than two policies, the baseline or a metric is unknown, the reference can bound
        neither regrets nor losses, or `evaluate` rejects an argument.

    Examples
    --------
    >>> import beltsort
    >>> model = beltsort.SortingModel(["nut", "bolt"], ["front"], [[[[0.8, 0.2], [0.2, 0.8]]]])
    >>> policies = {f"threshold {t}": beltsort.Threshold(model, t) for t in (0.9, 0.99)}
    >>> comparison = beltsort.compare(model, policies, batches=100, metrics=["steps", "correct"])
    >>> comparison.difference("threshold 0.99", "correct").mean > 0
    True
    """
    if len(policies) < 2:
        raise ArgumentError(
            f"{len(policies)} policies are given, expected at least two to compare; give more"
        )
    names = list(policies)
    chosen = names[0] if baseline is None else baseline
    _check("policy", chosen, names)
    drawn_from_model = true_classes is None and (truth is None or truth == model)
    if reference is not None:
        _check_reference(reference, model, drawn_from_model, belt_ends)
    evaluations = {
        name: evaluate(
            model,
            policy,
            batches=batches,
            batch_size=batch_size,
            seed=seed,
            threads=threads,
            viewpoint=viewpoint,
            true_classes=true_classes,
            truth=truth,
            max_looks=max_looks,
            reference=reference if reference is not None and reference.values_actions else None,
            belt_ends=belt_ends,
        )
        for name, policy in policies.items()
    }
    unbiased = list(evaluations[chosen].summary())
    compared = unbiased if metrics is None else list(metrics)
    for metric in compared:
        _check("metric", metric, unbiased)
    losses = {}
    if reference is not None and drawn_from_model:
        losses = {name: loss_bound(result, reference, viewpoint) for name, result in evaluations.items()}
    return Comparison(model, evaluations, chosen, tuple(compared), batch_size, seed, losses)


def _check_reference(
    reference: Solution, model: SortingModel, drawn_from_model: bool, belt_ends: bool
) -> None:
    reference.check_solves(model)
    if belt_ends:
        raise ArgumentError(
            "a reference bounds the value of belts that never end, and belt_ends has policies plan for one "
            "that does; leave one of them out"
        )
    if not reference.values_actions and not drawn_from_model:
        raise ArgumentError(
            "the reference is of a model with more than two positions, or with viewpoints that differ in "
            "their moves: it only bounds losses on objects and labels drawn from the model; leave out "
            "true_classes and truth, or the reference"
        )


def _check(what: str, name: str, names: Sequence[str]) -> None:
    if name not in names:
        raise ArgumentError(f"there is no {what} {name!r}, expected one of {', '.join(names)}; choose one")
