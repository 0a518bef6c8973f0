"""Means, differences, savings and slopes, each with what chance leaves open.

Batches of objects are independent of each other; conditions that are compared met the same batches, so every
statistic is of one number per batch.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import stdtr, stdtrit

from beltsort import ArgumentError

CONFIDENCE = 0.95


@dataclass(frozen=True)
class Estimate:
    """An estimated number.

    Attributes
    ----------
    value
        The estimate.
    standard_error
        Of it; NaN from a single batch.
    n
        Independent batches behind it.
    """

    value: float
    standard_error: float
    n: int

    @property
    def interval(self) -> tuple[float, float]:
        """The 95 % confidence interval, by Student's distribution."""
        half = float(stdtrit(max(self.n - 1, 1), (1.0 + CONFIDENCE) / 2.0)) * self.standard_error
        return self.value - half, self.value + half

    @property
    def p(self) -> float:
        """Probability that chance alone leads at least so far from zero; NaN from a single batch."""
        if self.standard_error == 0.0:
            return 1.0 if self.value == 0.0 else 0.0
        return float(2.0 * stdtr(max(self.n - 1, 1), -abs(self.value) / self.standard_error))


def mean(samples: ArrayLike) -> Estimate:
    """Return the mean of one number per batch.

    Examples
    --------
    >>> estimate = mean([1.0, 2.0, 3.0])
    >>> estimate.value, round(estimate.standard_error, 3), estimate.n
    (2.0, 0.577, 3)
    """
    values = np.asarray(samples, dtype=np.float64)
    n = len(values)
    error = float(values.std(ddof=1)) / math.sqrt(n) if n > 1 else math.nan
    return Estimate(float(values.mean()), error, n)


def difference(after: ArrayLike, before: ArrayLike) -> Estimate:
    """Return the mean of `after` minus `before`, batch by batch.

    Raises
    ------
    ArgumentError
        If they are not equally many.
    """
    first, second = _paired(after, before)
    return mean(first - second)


def saving(after: ArrayLike, before: ArrayLike) -> Estimate:
    """Return the share by which the mean of `after` is below that of `before`; paired, by the delta method.

    Raises
    ------
    ArgumentError
        If they are not equally many.

    Examples
    --------
    >>> round(saving([8.0, 9.0], [10.0, 10.0]).value, 3)
    0.15
    """
    first, second = _paired(after, before)
    ratio = first.mean() / second.mean()
    residual = mean((first - ratio * second) / second.mean())
    return Estimate(float(1.0 - ratio), residual.standard_error, len(first))


def unpaired(first: ArrayLike, second: ArrayLike) -> Estimate:
    """Return the difference of two means of unrelated batches; its degrees of freedom are the fewer ones."""
    one, other = mean(first), mean(second)
    error = math.hypot(one.standard_error, other.standard_error)
    return Estimate(one.value - other.value, error, min(one.n, other.n))


def slope(x: Sequence[float], samples: Sequence[ArrayLike]) -> Estimate:
    """Return by how much a number grows per unit of `x`: the mean of the batches' own regression lines.

    Parameters
    ----------
    x
        At least two different values.
    samples
        For each of them, one number per batch; the batches are the same for all.

    Examples
    --------
    >>> slope([0.0, 1.0, 2.0], [[1.0, 0.0], [2.0, 2.0], [3.0, 4.0]]).value
    1.5
    """
    centred = np.asarray(x, dtype=np.float64) - np.mean(x)
    values = np.asarray(samples, dtype=np.float64)  # (values of x, batches)
    return mean(centred @ values / (centred @ centred))


def _paired(first: ArrayLike, second: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    one, other = np.asarray(first, dtype=np.float64), np.asarray(second, dtype=np.float64)
    if one.shape != other.shape:
        raise ArgumentError(f"{len(one)} and {len(other)} batches cannot be paired; give the same batches")
    return one, other
