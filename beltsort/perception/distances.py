r"""Distances of histograms.

============ ===========================================================================
`chi2`       :math:`\sum_i (a_i - b_i)^2 / (a_i + b_i)` over bins not empty in both
`l1`         :math:`\sum_i |a_i - b_i|`
`l2`         :math:`\sqrt{\sum_i (a_i - b_i)^2}`
============ ===========================================================================
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Values = NDArray[np.float64]

BLOCK = 256  # descriptors at a time, so that intermediate results stay in the processor's cache


@dataclass(frozen=True)
class Distance:
    """A sum over bins.

    Attributes
    ----------
    term
        What a bin adds, from the stored value and the (positive) value of the query.
    term_at_zero
        The same where the query's value is 0, as in most bins of a descriptor.
    finish
        Converts the sum to the distance.
    """

    term: Callable[[Values, Values], Values]
    term_at_zero: Callable[[Values], Values]
    finish: Callable[[Values], Values]


def _itself(values: Values) -> Values:
    return values


def _squared_over_sum(a: Values, b: Values) -> Values:
    difference = a - b
    difference *= difference
    difference /= a + b
    return difference


DISTANCES = {
    "chi2": Distance(_squared_over_sum, _itself, _itself),
    "l1": Distance(lambda a, b: np.abs(a - b), _itself, _itself),
    "l2": Distance(lambda a, b: np.square(a - b), np.square, np.sqrt),
}


def distances_to(name: str, bins: Values, histogram: Values) -> Values:
    """Return the distances of a histogram to stored ones, shape (n,).

    Parameters
    ----------
    name
        A key of `DISTANCES`.
    bins
        The stored ones, one row for each bin, shape (m, n), not negative.
    histogram
        Shape (m,), not negative.

    Examples
    --------
    >>> stored = np.array([[1.0, 0.0], [0.0, 4.0]])  # two histograms of two bins, in columns
    >>> [distances_to(name, stored, np.array([3.0, 0.0])).tolist() for name in ("chi2", "l1", "l2")]
    [[1.0, 7.0], [2.0, 7.0], [2.0, 5.0]]
    """
    distance = DISTANCES[name]
    filled, values = np.flatnonzero(histogram > 0.0), histogram[histogram > 0.0, None]
    empty = np.flatnonzero(histogram == 0.0)
    sums = np.empty(bins.shape[1])
    for start in range(0, len(sums), BLOCK):
        block = bins[:, start : start + BLOCK]
        sums[start : start + BLOCK] = distance.term(block[filled], values).sum(axis=0)
        sums[start : start + BLOCK] += distance.term_at_zero(block[empty]).sum(axis=0)
    return distance.finish(sums)
