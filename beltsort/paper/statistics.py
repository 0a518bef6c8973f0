"""Means, differences, savings and slopes with their standard errors, and claims that rest on them.

Batches of objects are independent of each other; conditions that are compared met the same batches, so every
statistic is of one number per batch.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from enum import StrEnum
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from beltsort import ArgumentError
from beltsort.util.extras import extra
from beltsort.util.text import number_or_none

with extra("perception"):
    from scipy.special import stdtr, stdtrit

CONFIDENCE = 0.95
FEWEST = 10
"""Fewest batches to conclude from: outcomes are whole numbers, and few of them may agree by chance."""


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
        """The two-sided p-value of Student's test that the true value is zero; NaN from a single batch."""
        if self.standard_error == 0.0:
            return 1.0 if self.value == 0.0 else 0.0
        return float(2.0 * stdtr(max(self.n - 1, 1), -abs(self.value) / self.standard_error))

    def in_words(self, unit: str = "", *, factor: float = 1.0, digits: int = 1) -> str:
        """Return the value with its interval and p-value as text; `factor` converts it to `unit`.

        Examples
        --------
        >>> Estimate(0.152, 0.004, 1000).in_words(" %", factor=100)
        '15.2 % (95 % interval 14.4 to 16.0 %; p < 0.001)'
        """
        numbers = (self.value, *self.interval)
        value, lower, upper = (f"{factor * number:.{digits}f}" for number in numbers)
        p = "p < 0.001" if self.p < 0.001 else f"p = {self.p:.3f}"
        if math.isnan(self.p):
            p = "p unknown from a single batch"
        return f"{value}{unit} (95 % interval {lower} to {upper}{unit}; {p})"


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
    """Return the difference of two means of unrelated batches; `n` is that of the fewer batches."""
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


class Conclusion(StrEnum):
    """Whether a claim holds."""

    HOLDS = "holds"
    """The whole confidence interval is on the claim's side."""

    FAILS = "fails"
    """The whole confidence interval is on the other side."""

    OPEN = "open"
    """The interval reaches across, or there are fewer than `FEWEST` batches: more would be needed."""


def conclude(estimate: Estimate, above: float) -> Conclusion:
    """Return whether a number is above a limit.

    Examples
    --------
    >>> print(conclude(Estimate(0.2, 0.01, 100), above=0.1))
    holds
    >>> print(conclude(Estimate(0.2, 0.1, 100), above=0.1))
    open
    """
    lower, upper = estimate.interval
    if estimate.n < FEWEST:
        return Conclusion.OPEN
    if lower > above:
        return Conclusion.HOLDS
    return Conclusion.FAILS if upper < above else Conclusion.OPEN


@dataclass(frozen=True)
class ClaimResult:
    """Whether a claim holds under one condition.

    Attributes
    ----------
    claim
        In a few words.
    where
        The condition: level, tables, objects, discount.
    conclusion
        Whether it holds.
    estimate
        The number that it rests on.
    text
        A sentence with the numbers.
    """

    claim: str
    where: str
    conclusion: Conclusion
    estimate: Estimate
    text: str

    def plain(self) -> dict[str, Any]:
        """Return it as plain data for JSON and CSV; numbers that are not finite become None."""
        lower, upper = self.estimate.interval
        numbers = asdict(self.estimate) | {"lower": lower, "upper": upper, "p": self.estimate.p}
        return {
            "claim": self.claim,
            "where": self.where,
            "verdict": str(self.conclusion),
            **{name: number_or_none(value) for name, value in numbers.items()},
            "text": self.text,
        }

    @classmethod
    def from_plain(cls, plain: Mapping[str, Any]) -> "ClaimResult":
        """Return the result that `plain` has made plain data, also from the text of a CSV file.

        Raises
        ------
        KeyError, ValueError
            If a key is missing, or a value is not of its kind.
        """
        value, error = (float(plain[name] or "nan") for name in ("value", "standard_error"))
        return cls(
            plain["claim"],
            plain["where"],
            Conclusion(plain["verdict"]),
            Estimate(value, error, int(plain["n"])),
            plain["text"],
        )
