"""Tables of few objects, shrunk towards what all their rows have in common.

A uniform prior of one pseudo-look per label outweighs the objects of a row where these are fewer than the
labels: a classifier that is nearly always right then seems to be nearly always wrong. How often labels are
right is known much better from all rows together.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

import beltsort
from beltsort.tables.counts import Counts

Array = NDArray[np.float64]

PSEUDO_LOOKS = 4.0


def pooled_probabilities(
    counts: Counts, label_classes: Sequence[int | None] | None = None, *, pseudo_looks: float = PSEUDO_LOOKS
) -> Array:
    """Return the observation table, each row shrunk towards the mean of all rows, shape (H, K, L, Z).

    The prior of a row has the share of right labels of all rows together, and that of wrong labels, equal for
    all wrong classes; each by level of confidence, and with the share of every label that names no class.
    These shares are smoothed by one pseudo-look each, so no entry is 0.

    Parameters
    ----------
    counts
        Label counts of independent objects.
    label_classes
        The class that each label names, or None, shape (Z,), as `LabelRule.label_classes`. The labels are the
        classes if missing.
    pseudo_looks
        Looks that the prior of a row counts for. Too few, and rows of few objects are chance; too many, and
        all classes are confused alike.

    Raises
    ------
    ArgumentError
        If `pseudo_looks` is not a positive number, or `label_classes` has another length than the table.

    Examples
    --------
    >>> from beltsort.tables.counts import Look, count
    >>> counts = count([Look(0, 0, true=c, observed=c) for c in range(3)], 1, 1, 3)
    >>> counts.probabilities(smoothing=1.0)[0, 0, 0].tolist()
    [0.5, 0.25, 0.25]
    >>> pooled_probabilities(counts)[0, 0, 0].round(2).tolist()
    [0.84, 0.08, 0.08]
    """
    if not 0.0 < pseudo_looks < np.inf:
        raise beltsort.ArgumentError(f"pseudo_looks is {pseudo_looks}, expected a positive number: try 4")
    table = counts.counts
    named = list(range(table.shape[2])) if label_classes is None else list(label_classes)
    if len(named) != table.shape[3]:
        raise beltsort.ArgumentError(
            f"label_classes has {len(named)} entries, expected {table.shape[3]}, one for each label: give "
            "those of the rule that made the labels"
        )
    outcomes = _outcomes(named, table.shape[2])
    number = int(outcomes.max()) + 1
    seen = np.bincount(outcomes.ravel(), weights=table.sum(axis=(0, 1)).ravel(), minlength=number)
    shares = (seen + 1.0) / (seen.sum() + number)
    ways = np.stack([np.bincount(row, minlength=number) for row in outcomes])
    prior = shares[outcomes] / np.take_along_axis(ways, outcomes, axis=1)
    pseudo_counts = table + pseudo_looks * prior / prior.sum(axis=1, keepdims=True)
    probabilities: Array = pseudo_counts / pseudo_counts.sum(axis=-1, keepdims=True)
    return probabilities


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
