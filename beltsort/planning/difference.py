"""Differences between policies on the same objects, paired by batch."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

CONFIDENCE = 0.95
"""Of two-sided intervals; a difference is significant if its interval excludes 0."""


def half_interval(standard_error: float) -> float:
    """Return half of the width of the 95 % confidence interval, by the normal distribution.

    Examples
    --------
    >>> round(half_interval(0.5), 2)
    0.98
    """
    return NormalDist().inv_cdf((1.0 + CONFIDENCE) / 2.0) * standard_error


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

    @property
    def interval(self) -> tuple[float, float]:
        """Ends of the 95 % confidence interval, by the normal distribution; NaN for a single batch."""
        half = half_interval(self.standard_error)
        return self.mean - half, self.mean + half

    @property
    def significant(self) -> bool:
        """Whether the interval excludes 0."""
        lower, upper = self.interval
        return lower > 0.0 or upper < 0.0


def paired_difference(sample: NDArray[np.float64], reference: NDArray[np.float64]) -> Difference:
    """Return the mean of `sample` minus `reference`, both of shape (batches,), with its standard error."""
    differences = sample - reference
    n = len(differences)
    error = float(differences.std(ddof=1)) / math.sqrt(n) if n > 1 else math.nan
    return Difference(float(differences.mean()), error)


@dataclass(frozen=True)
class PairedStatistics:
    """What a comparison of policies shows: means, and differences from a baseline.

    Attributes
    ----------
    baseline
        Name of the policy that the others are compared with.
    metrics
        Names of the compared properties of `Evaluation`.
    batches, batch_size
        Number of batches, and decisions per batch.
    summary
        Mean and standard error, ``[policy][metric]["mean"]`` and ``["standard_error"]``.
    differences
        Differences of all policies but the baseline from it, ``[policy][metric]``.
    """

    baseline: str
    metrics: tuple[str, ...]
    batches: int
    batch_size: int
    summary: Mapping[str, Mapping[str, Mapping[str, float]]]
    differences: Mapping[str, Mapping[str, Difference]]
