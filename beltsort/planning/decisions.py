"""Decisions: the bin that earns most, and whether a bin is right."""

from collections.abc import Iterable, Sequence
from itertools import islice
from math import fsum

import numpy as np
from numpy.typing import NDArray

from beltsort._core import Belief, SortingModel

EQUAL = 1e-9
"""Difference of probabilities below which classes count as equally likely."""


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


def class_probabilities(model: SortingModel, kinds: Iterable[float]) -> list[float]:
    """Return the probability of each class of an object: the sum over the modes of the class.

    Parameters
    ----------
    model
        The model, with L classes and N kinds.
    kinds
        N probabilities, one per kind, as a row of `Belief.kinds`.

    Returns
    -------
    list of float
        L probabilities.

    Examples
    --------
    >>> from beltsort.models import paper
    >>> class_probabilities(paper(), [0.5, 0.25, 0.25, 0.0])  # one mode per class
    [0.5, 0.25, 0.25, 0.0]
    """
    left = iter(kinds)
    return [sum(islice(left, len(weights)), 0.0) for weights in model.modes]


def likeliest_classes(probabilities: Sequence[float]) -> list[int]:
    """Return the most likely class of an object, or all classes that are equally and most likely.

    Examples
    --------
    >>> likeliest_classes([0.2, 0.5, 0.3]), likeliest_classes([0.4, 0.4, 0.2])
    ([1], [0, 1])
    """
    most = max(probabilities)
    return [label for label, p in enumerate(probabilities) if p > most - EQUAL]


def likeliest_in_words(probabilities: Sequence[float], classes: Sequence[str]) -> str:
    """Return the most likely class by name; where several are equally likely, all of them.

    Parameters
    ----------
    probabilities
        L class probabilities of an object.
    classes
        Names of the L classes.

    Examples
    --------
    >>> names = ["nut", "bolt", "washer"]
    >>> likeliest_in_words([0.2, 0.5, 0.3], names), likeliest_in_words([0.4, 0.4, 0.2], names)
    ('bolt', 'nut or bolt')
    >>> likeliest_in_words([1 / 3, 1 / 3, 1 / 3], names)
    'any class'
    """
    found = likeliest_classes(probabilities)
    if len(found) == len(classes) > 1:
        return "any class"
    return " or ".join(classes[label] for label in found)
