"""Policies compared on the same objects."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from beltsort._core import ArgumentError, Evaluation, Solution, SortingModel, evaluate
from beltsort.planning.policy import Policy
from beltsort.util.text import numbers_or_none, text_table


@dataclass(frozen=True)
class Difference:
    """A mean difference over paired batches.

    Attributes
    ----------
    mean
        Sample mean of the differences.
    standard_error
        Of that mean; NaN for a single batch.
    """

    mean: float
    standard_error: float

    @property
    def z(self) -> float:
        """The mean in standard errors: beyond 2 or so in size, chance alone is an unlikely explanation."""
        if self.standard_error == 0:
            return math.copysign(math.inf, self.mean) if self.mean else 0.0
        return self.mean / self.standard_error


@dataclass(frozen=True, eq=False)
class Comparison:
    """Policies evaluated on the same batches, and what they differ by; `str` gives a table.

    Attributes
    ----------
    evaluations
        The outcomes of each policy, by its name.
    baseline
        Name of the policy that the others are held against.
    metrics
        Outcomes compared: properties of `Evaluation`.
    batch_size
        Decisions per batch.
    seed
        Of classes and labels.
    """

    evaluations: Mapping[str, Evaluation]
    baseline: str
    metrics: tuple[str, ...]
    batch_size: int
    seed: int

    def outcomes(self, policy: str, metric: str) -> NDArray[np.float64]:
        """Return one outcome of a policy for every batch, float64 of shape (batches,).

        Raises
        ------
        ArgumentError
            For an unknown policy or metric, listing those that there are.
        """
        _check("policy", policy, list(self.evaluations))
        _check("metric", metric, self.metrics)
        return np.asarray(getattr(self.evaluations[policy], metric), dtype=np.float64)

    def difference(self, policy: str, metric: str, other: str | None = None) -> Difference:
        """Return by how much a policy's outcome exceeds that of another one.

        The batches are paired: both policies met the same objects, and what the objects contribute to both
        cancels.

        Parameters
        ----------
        policy, other
            Names; the baseline if `other` is missing.
        metric
            One of `metrics`.

        Returns
        -------
        Difference
            Mean over batches of `policy` minus `other`, with its standard error.

        Raises
        ------
        ArgumentError
            For an unknown policy or metric, listing those that there are.
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
        """Return what each policy differs from the baseline by, ``[policy][metric]``."""
        return {
            name: {metric: self.difference(name, metric) for metric in self.metrics}
            for name in self.evaluations
            if name != self.baseline
        }

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
        }

    def __str__(self) -> str:
        """Lay out means and paired differences as plain text, a row per metric."""
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
    batches: int = 1000,
    batch_size: int = 10,
    seed: int = 0,
    threads: int | None = None,
    viewpoint: int = 0,
    true_classes: ArrayLike | None = None,
    truth: SortingModel | None = None,
    max_looks: int = 60,
    reference: Solution | None = None,
    belt_ends: bool = False,
    baseline: str | None = None,
    metrics: Sequence[str] | None = None,
) -> Comparison:
    """Evaluate policies on the same batches.

    Randoms are indexed by (batch, object, look), so that every policy meets the same objects; differences
    are taken batch by batch, and have far smaller standard errors than the means. A baseline that is to be
    beaten is best tuned on other seeds.

    Parameters
    ----------
    model, batches, batch_size, seed, threads, viewpoint, true_classes, truth, max_looks, reference, belt_ends
        As `evaluate` takes them.
    policies
        At least two policies by name: whatever `evaluate` accepts.
    baseline
        Name of the policy that the others are held against; the first if missing.
    metrics
        Outcomes to compare, by their names in `Evaluation`; every one that is unbiased if missing. The more
        are looked at, the likelier that one of them seems to differ by chance.

    Returns
    -------
    Comparison
        The outcomes of every policy, their means and their paired differences.

    Raises
    ------
    ArgumentError
        For fewer than two policies, an unknown baseline or metric, and whatever `evaluate` refuses.

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
        raise ArgumentError(f"{len(policies)} policies: give at least two to compare")
    names = list(policies)
    chosen = names[0] if baseline is None else baseline
    _check("policy", chosen, names)
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
            reference=reference,
            belt_ends=belt_ends,
        )
        for name, policy in policies.items()
    }
    unbiased = list(evaluations[chosen].summary())
    compared = unbiased if metrics is None else list(metrics)
    for metric in compared:
        _check("metric", metric, unbiased)
    return Comparison(evaluations, chosen, tuple(compared), batch_size, seed)


def _check(what: str, name: str, names: Sequence[str]) -> None:
    if name not in names:
        raise ArgumentError(f"there is no {what} {name!r} here; there are {', '.join(names)}")
