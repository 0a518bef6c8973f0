"""Edges of the levels of confidence, from matches of objects of known class."""

from collections.abc import Iterable, Sequence
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

import beltsort
from beltsort.perception.classifier import Match
from beltsort.perception.label_rule import MOST_LEVELS, LabelRule, Score, score_of

Array: TypeAlias = NDArray[np.float64]
Integers: TypeAlias = NDArray[np.int64]
Method: TypeAlias = Literal["quantiles", "information"]

PARTS = 20  # edges lie between parts of equally many scores, so that a level has at least 5 % of them


def fit_label_rule(
    classes: Sequence[str],
    matches: Iterable[Match],
    true_labels: Iterable[int],
    levels: int = 2,
    *,
    method: Method = "quantiles",
    score: Score = "margin",
    not_recognised: bool = False,
    nothing_seen: bool = False,
) -> LabelRule:
    """Fit the edges of a rule.

    Parameters
    ----------
    classes
        Names of the classes.
    matches
        What the classifier returned for objects that it was not trained on, or `leave_one_out` for the
        entries of a database. Rejected ones are not used.
    true_labels
        Class index of each.
    levels
        Number of levels, from 1 to 4. There will be fewer if too few scores differ.
    method
        `quantiles`: every level has equally many scores. `information`: the mutual information of label and
        class is as large as possible with edges at twentieths of the scores. It can fit chance, with few
        matches above all.
    score, not_recognised, nothing_seen
        As in `LabelRule`.

    Raises
    ------
    ArgumentError
        If `levels` is out of range, `method` is unknown, or there is no match to cut levels from.
    DatabaseError
        If the matches do not tell what `score` needs.

    Examples
    --------
    >>> margins = np.array([0.0, 0.125, 0.25, 0.5, 0.75, 1.0])
    >>> matches = [Match(0, np.ones(2), np.array([1.0 - m, 1.0 + m])) for m in margins]
    >>> true = [0, 1, 1, 0, 0, 0]
    >>> fit_label_rule(["bulb", "cup"], matches, true).edges
    (0.375,)
    """
    if type(levels) is not int or not 1 <= levels <= MOST_LEVELS:
        raise beltsort.ArgumentError(f"levels is {levels!r}, expected an integer from 1 to {MOST_LEVELS}")
    if method not in ("quantiles", "information"):
        raise beltsort.ArgumentError(f"method is {method!r}, expected 'quantiles' or 'information'")
    edges: tuple[float, ...] = ()
    if levels > 1:
        scores, labels, true = _recognised(matches, true_labels, score)
        if method == "quantiles":
            edges = quantile_edges(scores, levels)
        else:
            edges = informative_edges(scores, labels, true, levels)
    return LabelRule(tuple(classes), edges, score, not_recognised, nothing_seen)


def _recognised(
    matches: Iterable[Match], true_labels: Iterable[int], score: Score
) -> tuple[Array, Integers, Integers]:
    """Return score, label and true class of the matches that have a label, shape (n,) each."""
    rows = [
        (score_of(match, score), match.label, true)
        for match, true in zip(matches, true_labels, strict=True)
        if match.label is not None
    ]
    if not rows:
        raise beltsort.ArgumentError(
            "there are 0 matches with a label, expected some to cut levels from: train with more objects"
        )
    scores, labels, true = zip(*rows, strict=True)
    return np.array(scores), np.array(labels, np.int64), np.array(true, np.int64)


def quantile_edges(scores: Array, levels: int) -> tuple[float, ...]:
    """Return the edges between levels of equally many scores; fewer if too few scores differ.

    Parameters
    ----------
    scores
        Finite, shape (n,), n > 0.
    levels
        Number of levels.

    Examples
    --------
    >>> quantile_edges(np.array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]), 3)
    (2.5, 4.5)
    >>> quantile_edges(np.array([1.0, 1.0, 1.0, 1.0, 2.0]), 3)
    (1.5,)
    """
    ordered = np.sort(scores)
    edges: list[float] = []
    for level in range(1, levels):
        edge = _edge_at(ordered, round(len(ordered) * level / levels))
        if edge is not None and edge not in edges:
            edges.append(edge)
    return tuple(edges)


def _edge_at(ordered: Array, rank: int) -> float | None:
    """Return an edge with `rank` scores below it, or as near as equal scores allow; None if all are equal.

    The edge lies halfway between two scores, so that neither is at the edge by rounding.
    """
    tied = ordered[min(max(rank, 1), len(ordered)) - 1]
    ends = [int(np.searchsorted(ordered, tied, side)) for side in ("left", "right")]
    possible = [end for end in ends if 0 < end < len(ordered)]
    if not possible:
        return None
    end = min(possible, key=lambda end: abs(end - rank))
    edge = 0.5 * float(ordered[end - 1]) + 0.5 * float(ordered[end])
    # Neighbouring floating-point numbers have nothing between them.
    return edge if edge > ordered[end - 1] else float(ordered[end])


def informative_edges(scores: Array, labels: Integers, true: Integers, levels: int) -> tuple[float, ...]:
    """Return the edges with the largest mutual information of (label, level) and true class.

    It is a sum over levels, up to a constant, so dynamic programming over the possible edges finds the best
    ones. With more levels it is never smaller, whatever they are worth on other objects.

    Parameters
    ----------
    scores, labels, true
        Score, label and true class of each match, shape (n,), n > 0.
    levels
        Number of levels.
    """
    possible = quantile_edges(scores, PARTS)
    parts = np.searchsorted(possible, scores, side="right")  # between which possible edges each score lies
    counts = np.zeros((len(possible) + 2, labels.max() + 1, true.max() + 1))
    np.add.at(counts, (parts + 1, labels, true), 1.0)
    below = counts.cumsum(axis=0)  # (P + 1, L, L): counts in the parts before each of the P + 1 boundaries
    best: list[tuple[float, tuple[int, ...]]] = [
        (_information(below[end]), ()) for end in range(len(possible) + 2)
    ]
    for _ in range(min(levels - 1, len(possible))):
        best = [
            max(
                (best[end], *(_extended(best[cut], cut, below, end) for cut in range(1, end))),
                key=lambda found: found[0],
            )
            for end in range(len(possible) + 2)
        ]
    return tuple(possible[cut - 1] for cut in best[-1][1])


def _extended(
    before: tuple[float, tuple[int, ...]], cut: int, below: Array, end: int
) -> tuple[float, tuple[int, ...]]:
    """Add a level from boundary `cut` to boundary `end` to the best levels before it."""
    return before[0] + _information(below[end] - below[cut]), (*before[1], cut)


def _information(counts: Array) -> float:
    """Return what a level with counts (L, L) adds to n times the mutual information, up to a constant."""
    return _sum_n_log_n(counts) - _sum_n_log_n(counts.sum(axis=1))


def _sum_n_log_n(counts: Array) -> float:
    """Return the sum of n log n over counts n, 0 for n = 0; without SciPy, which planning does not need."""
    return float((counts * np.log(np.maximum(counts, 1.0))).sum())
