r"""The expected calibration error of beliefs.

A pair is a belief p in a class and whether the object is of it (y = 1) or not (y = 0). With n pairs, of which
n_b in bin b of `EDGES`,

.. math:: \text{ECE} = \sum_b \frac{n_b}{n} \, \Big| \overline{p}_b - \overline{y}_b \Big| .

References
----------
M. P. Naeini, G. F. Cooper, M. Hauskrecht, "Obtaining well calibrated probabilities using Bayesian binning",
AAAI 2015.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

EDGES = (0.0, 0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.98, 1.0)
"""Edges of the bins, finer towards 0 and 1, where beliefs are; the same for every sample."""


def bins_of(beliefs: Array) -> NDArray[np.int64]:
    """Return the index of each belief's bin; a belief on an edge is in the upper one."""
    return np.clip(np.searchsorted(EDGES, beliefs, side="right") - 1, 0, len(EDGES) - 2)


def error_of_bins(counts: NDArray[Any], belief: Array, hits: Array) -> Array:
    """Return the error of numbers of pairs, sums of beliefs and of y in each bin, shape (..., bins) each."""
    error: Array = np.abs(belief - hits).sum(axis=-1) / counts.sum(axis=-1)
    return error


def calibration_error(beliefs: Array, true: NDArray[np.int64]) -> float:
    """Return the error of beliefs in classes.

    Parameters
    ----------
    beliefs
        Probabilities, shape (n, L).
    true
        Class indices, shape (n,).

    Examples
    --------
    >>> calibration_error(np.array([[0.75, 0.25]] * 4), np.array([0, 1, 0, 0]))
    0.0
    >>> calibration_error(np.array([[0.75, 0.25]] * 4), np.array([1, 1, 1, 1]))
    0.75
    """
    hit = np.arange(beliefs.shape[1]) == true[:, np.newaxis]
    bins = bins_of(beliefs).ravel()
    counts = np.bincount(bins, minlength=len(EDGES) - 1)
    belief, hits = (np.bincount(bins, x.ravel(), len(EDGES) - 1).astype(np.float64) for x in (beliefs, hit))
    return float(error_of_bins(counts, belief, hits))
