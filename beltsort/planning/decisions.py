"""Decisions: the bin that earns most, and whether a bin is right."""

from math import fsum

import numpy as np
from numpy.typing import NDArray

from beltsort._core import Belief, SortingModel


def best_bin(belief: Belief, position: int = 0) -> int:
    """Return the bin with the largest expected reward, `argmax_b sum_c p(c) reward[b, c]`.

    Parameters
    ----------
    belief
        The belief, whose probabilities are p.
    position
        Belt position, 0 at the belt end.

    Returns
    -------
    int
        Index into `model.bins`; the lowest among equals.

    Examples
    --------
    >>> import beltsort
    >>> table = [[[[0.8, 0.2], [0.2, 0.8]]]]
    >>> reward = [[10.0, -50.0], [-50.0, 10.0], [-3.0, -3.0]]
    >>> model = beltsort.SortingModel(
    ...     ["nut", "bolt"], ["above"], table, bins=["nuts", "bolts", "by hand"], reward=reward
    ... )
    >>> model.bins[best_bin(beltsort.Belief(model, [[0.9, 0.1]]))]
    'nuts'
    >>> model.bins[best_bin(beltsort.Belief(model, [[0.6, 0.4]]))]
    'by hand'
    """
    # Exact sums do not depend on the order of the classes: equal beliefs stay equal.
    values = [fsum(row) for row in belief.model.reward * belief.probabilities[position]]
    return values.index(max(values))


def right_bins(model: SortingModel) -> NDArray[np.bool_]:
    """Return which classes belong into which bin: those for which no bin is worth more.

    Returns
    -------
    numpy.ndarray
        bool of shape (B, L), ``[bin, class]``.

    Examples
    --------
    >>> from beltsort.models import paper
    >>> right_bins(paper()).sum()
    np.int64(4)
    """
    reward = model.reward
    right: NDArray[np.bool_] = reward == reward.max(axis=0)
    return right


def probability_right(belief: Belief, bin: int, position: int = 0) -> float:
    """Return the probability that a bin is right for the object at a position."""
    return float(belief.probabilities[position][right_bins(belief.model)[bin]].sum())
