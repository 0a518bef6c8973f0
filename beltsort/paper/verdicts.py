"""Claims held against estimates."""

from dataclasses import asdict, dataclass
from enum import StrEnum
from typing import Any

from beltsort.paper.statistics import Estimate
from beltsort.util.text import number_or_none

FEWEST = 10
"""Batches below which nothing is said: outcomes are whole numbers, and few of them may agree by chance."""


class Verdict(StrEnum):
    """What the numbers say of a claim."""

    HOLDS = "holds"
    """The whole confidence interval is on the claim's side."""

    FAILS = "fails"
    """The whole confidence interval is on the other side."""

    OPEN = "open"
    """The interval reaches across, or there are fewer than `FEWEST` batches: more would be needed."""


def verdict(estimate: Estimate, above: float) -> Verdict:
    """Say whether a number is above a limit.

    Examples
    --------
    >>> print(verdict(Estimate(0.2, 0.01, 100), above=0.1))
    holds
    >>> print(verdict(Estimate(0.2, 0.1, 100), above=0.1))
    open
    """
    lower, upper = estimate.interval
    if estimate.n < FEWEST:
        return Verdict.OPEN
    if lower > above:
        return Verdict.HOLDS
    return Verdict.FAILS if upper < above else Verdict.OPEN


@dataclass(frozen=True)
class Finding:
    """One claim under one condition.

    Attributes
    ----------
    claim
        In a few words.
    where
        The condition: level, tables, objects, discount.
    verdict
        What the numbers say.
    estimate
        The number that it rests on.
    text
        A sentence with the numbers.
    """

    claim: str
    where: str
    verdict: Verdict
    estimate: Estimate
    text: str

    def plain(self) -> dict[str, Any]:
        """Return it as plain data for JSON and CSV; numbers that are not finite become None."""
        lower, upper = self.estimate.interval
        numbers = asdict(self.estimate) | {"lower": lower, "upper": upper, "p": self.estimate.p}
        return {
            "claim": self.claim,
            "where": self.where,
            "verdict": str(self.verdict),
            **{name: number_or_none(value) for name, value in numbers.items()},
            "text": self.text,
        }


def in_words(estimate: Estimate, unit: str = "", *, factor: float = 1.0, digits: int = 1) -> str:
    """Say a number with its interval and p-value.

    Examples
    --------
    >>> in_words(Estimate(0.152, 0.004, 1000), " %", factor=100)
    '15.2 % (95 % interval 14.4 to 16.0 %; p < 0.001)'
    """
    value, lower, upper = (f"{factor * number:.{digits}f}" for number in (estimate.value, *estimate.interval))
    return f"{value}{unit} (95 % interval {lower} to {upper}{unit}; {_chance(estimate.p)})"


def _chance(p: float) -> str:
    if p != p:
        return "p unknown from a single batch"
    return "p < 0.001" if p < 0.001 else f"p = {p:.3f}"
