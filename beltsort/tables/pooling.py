"""A prior for tables of few objects: what all of their rows have in common.

A uniform prior of one pseudo-look per label outweighs the objects of a row where these are fewer than the
labels: a classifier that is nearly always right then seems to be nearly always wrong. How often labels are
right is known much better from all rows together, and so is by how much rows differ.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from beltsort.tables.counts import Array, Counts, check_smoothing

# Weights of the prior that are compared, in looks, and the preference among them where the counts decide
# nothing: log-normal about USUAL.
WEIGHTS = tuple(2.0**exponent for exponent in range(-2, 11))
USUAL = 8.0
SPREAD = float(np.log(8.0))


def pooled_prior(counts: Counts, weight: float | None = None) -> Array:
    """Return pseudo-counts that shrink each row of a table towards the mean of all rows, shape (H, K, L, Z).

    The prior of a row has the share of right labels of all rows together, and that of wrong labels, equal for
    all wrong classes; each by level of confidence, and with the share of every label that names no class.
    These shares are smoothed by one pseudo-look each, so no entry is 0.

    Parameters
    ----------
    counts
        Label counts of independent objects.
    weight
        Looks that the prior of a row counts for, at most those that were counted in all rows. Default: what
        predicts each look best from the others, by empirical Bayes: large if rows differ no more than chance
        explains, small if they do. With few looks, about 8.

    Raises
    ------
    ArgumentError
        If `weight` is not a positive number.

    Examples
    --------
    >>> from beltsort.tables.counts import Look, count
    >>> counts = count([Look(0, 0, true=c, observed=c) for c in range(3)] * 2, 1, 1, 3)
    >>> counts.probabilities(smoothing=1.0)[0, 0, 0].tolist()
    [0.6, 0.2, 0.2]
    >>> counts.probabilities(pooled_prior(counts))[0, 0, 0].round(2).tolist()
    [0.93, 0.04, 0.04]
    """
    rows = _Rows(counts)
    if weight is None:
        weight = max(WEIGHTS, key=rows.score)
    check_smoothing(weight, labels=1)
    return rows.prior(weight)


class _Rows:
    """Counts, and what their labels mean."""

    def __init__(self, counts: Counts) -> None:
        self._counts = counts.counts.astype(np.float64)
        classes, labels = self._counts.shape[2:]
        named = range(labels) if counts.label_classes is None else counts.label_classes
        self._outcomes = _outcomes(list(named), classes)
        number = int(self._outcomes.max()) + 1
        seen = np.bincount(
            self._outcomes.ravel(), weights=self._counts.sum(axis=(0, 1)).ravel(), minlength=number
        )
        self._seen = seen[self._outcomes] + 1.0  # (L, Z)
        self._total = float(seen.sum()) + number
        ways = np.stack([np.bincount(row, minlength=number) for row in self._outcomes])
        self._ways = np.take_along_axis(ways, self._outcomes, axis=1)

    def prior(self, weight: float) -> Array:
        """Return the pseudo-counts of every row, shape (H, K, L, Z)."""
        shares = self._seen / self._ways
        shares = shares / shares.sum(axis=1, keepdims=True)
        return np.broadcast_to(_at_most(weight, self._total) * shares, self._counts.shape).copy()

    def score(self, weight: float) -> float:
        """Return the log-probability of each look given all others, plus the preference for a weight."""
        shares = (self._seen - 1.0) / self._ways / (self._total - 1.0)
        weight_used = _at_most(weight, self._total - 1.0)
        rest = self._counts - 1.0 + weight_used * shares
        predicted = rest / (self._counts.sum(axis=-1, keepdims=True) - 1.0 + weight_used)
        seen = self._counts > 0.0
        looks = float((self._counts[seen] * np.log(predicted[seen])).sum())
        return looks - float(np.log(weight / USUAL) ** 2) / (2.0 * SPREAD**2)


def _at_most(weight: float, total: float) -> float:
    """Return the weight of a prior that is itself known from `total` looks: their variances add."""
    return 1.0 / (1.0 / weight + 1.0 / total)


def _outcomes(named: Sequence[int | None], classes: int) -> NDArray[np.int64]:
    """Return a number for what a label means for a class, right or wrong at a level or neither, (L, Z)."""
    kinds: dict[tuple[str, int], int] = {}
    outcomes = np.empty((classes, len(named)), dtype=np.int64)
    for true in range(classes):
        for label, name in enumerate(named):
            level = label if name is None else label - named.index(name)
            meaning = "none" if name is None else "right" if name == true else "wrong"
            outcomes[true, label] = kinds.setdefault((meaning, level), len(kinds))
    return outcomes
