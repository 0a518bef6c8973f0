"""The statistical error of a table: standard errors, credible intervals, and how many objects are needed.

Each row has a Dirichlet posterior, the pseudo-counts of the prior of `Counts.probabilities` plus the counts;
each entry of it has a Beta distribution.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import beltsort
from beltsort.tables.counts import Array, Counts
from beltsort.util.defaults import TARGET_ERROR
from beltsort.util.extras import extra

with extra("perception"):
    from scipy.special import betaincinv

CREDIBILITY = 0.95


def standard_errors(counts: Counts, smoothing: float | Array) -> Array:
    """Return the posterior standard deviation of every entry, shape (H, K, L, Z).

    Examples
    --------
    >>> from beltsort.tables import Look, count
    >>> counts = count([Look(0, 0, 0, 0)] * 3, positions=1, viewpoints=1, classes=2)
    >>> standard_errors(counts, smoothing=1.0)[0, 0].round(3).tolist()
    [[0.163, 0.163], [0.289, 0.289]]
    """
    mean = counts.probabilities(smoothing)
    weight = (counts.counts + smoothing).sum(axis=-1, keepdims=True)
    errors: Array = np.sqrt(mean * (1.0 - mean) / (weight + 1.0))
    return errors


def credible_intervals(counts: Counts, smoothing: float | Array) -> tuple[Array, Array]:
    """Return the lower and upper ends of the 95 % intervals, equal tails, shape (H, K, L, Z) each."""
    return dirichlet_intervals(counts.counts.astype(np.float64) + smoothing)


def dirichlet_intervals(parameters: Array) -> tuple[Array, Array]:
    """Return the ends of the 95 % intervals of rows with a Dirichlet distribution of these parameters."""
    others = parameters.sum(axis=-1, keepdims=True) - parameters
    tail = (1.0 - CREDIBILITY) / 2.0
    if parameters.shape[-1] == 1:
        return np.ones(parameters.shape), np.ones(parameters.shape)
    return betaincinv(parameters, others, tail), betaincinv(parameters, others, 1.0 - tail)


@dataclass(frozen=True)
class WorstRow:
    """The table row with the largest standard error.

    Attributes
    ----------
    position, viewpoint, true
        Indices of the row.
    error
        The largest standard error in it.
    objects
        Objects counted in it.
    missing
        Further objects after which all of its entries would have at most the wanted error, if the
        probabilities stay as estimated.
    """

    position: int
    viewpoint: int
    true: int
    error: float
    objects: int
    missing: int


def worst_row(counts: Counts, smoothing: float | Array, wanted: float) -> WorstRow:
    """Return the row with the largest standard error.

    Parameters
    ----------
    counts, smoothing
        As in `standard_errors`.
    wanted
        The largest standard error that an entry may have.

    Raises
    ------
    ArgumentError
        If `wanted` is not between 0 and 1.
    """
    errors = standard_errors(counts, smoothing).max(axis=-1)
    needed = objects_needed(counts, smoothing, wanted)
    row = np.unravel_index(int(errors.argmax()), errors.shape)
    position, viewpoint, true = (int(index) for index in row)
    objects = int(counts.counts[row].sum())
    return WorstRow(position, viewpoint, true, float(errors[row]), objects, int(needed[row]))


def objects_needed(counts: Counts, smoothing: float | Array, wanted: float) -> NDArray[np.int64]:
    """Return how many more objects each row needs, shape (H, K, L): see `worst_row`."""
    check_error(wanted)
    mean = counts.probabilities(smoothing)
    variance = (mean * (1.0 - mean)).max(axis=-1)
    weight = (counts.counts + smoothing).sum(axis=-1)
    missing: Array = np.ceil(np.maximum(variance / wanted**2 - 1.0 - weight, 0.0))
    return missing.astype(np.int64)


def check_error(wanted: float) -> None:
    """Raise an `ArgumentError` unless `wanted` is between 0 and 1."""
    if not 0.0 < wanted < 1.0:
        raise beltsort.ArgumentError(
            f"the wanted standard error is {wanted}, expected a number between 0 and 1, such as "
            f"{TARGET_ERROR:g}"
        )
