r"""Expectation maximisation for the latent modes of one class.

The looks at an object are independent given its mode. With :math:`n_{oz}` how often object o gave label z in
a table row (row and label are one index here), weights :math:`w_m` and tables :math:`\theta_{mz}`, the
penalised log-likelihood is

.. math:: \sum_o \log \sum_m w_m \prod_z \theta_{mz}^{n_{oz}}
          + \sum_{m,z} a_{mz} \log \theta_{mz} + \alpha \sum_m \log w_m ,

the logarithm of the posterior density with a pseudo-looks (a Dirichlet prior with parameters
:math:`a + 1`) and :math:`\alpha` pseudo-objects. The E-step computes :math:`r_{om}`, the posterior of each
object's mode; the M-step sets :math:`\theta_{mz} \propto a_{mz} + \sum_o r_{om} n_{oz}` and
:math:`w_m \propto \alpha + \sum_o r_{om}`. No iteration lowers the penalised log-likelihood. It has many
maxima, so several starts run at once.

References
----------
A. P. Dempster, N. M. Laird, D. B. Rubin, "Maximum likelihood from incomplete data via the EM algorithm",
J. R. Stat. Soc. B 39 (1977). P. F. Lazarsfeld, N. W. Henry, "Latent structure analysis", Houghton Mifflin
1968.
"""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from beltsort.util.extras import extra

with extra("perception"):
    from scipy.special import logsumexp

Array = NDArray[np.float64]

TOLERANCE = 1e-9  # of the gain of one iteration, per object
MOST_ITERATIONS = 1000


@dataclass(frozen=True, eq=False)
class Mixture:
    """Modes of one class, of S starts at once: M modes, T table rows, Z labels.

    Attributes
    ----------
    weights
        Shape (S, M).
    tables
        Shape (S, M, T, Z); rows sum to 1.
    """

    weights: Array
    tables: Array

    def only(self, start: int, modes: NDArray[np.int64]) -> Self:
        """Return some modes of one start, as the only start."""
        weights = self.weights[start : start + 1, modes]
        return replace(self, weights=weights / weights.sum(), tables=self.tables[start : start + 1, modes])


@dataclass(frozen=True, eq=False)
class Problem:
    """What EM maximises for one class.

    Attributes
    ----------
    counts
        Labels of each object, shape (n, T, Z).
    possible
        Which modes an object may have, shape (n, M): all, or the one that is known.
    pseudo_looks
        Parameters a of the tables' prior, positive, shape (M, T, Z) or (T, Z).
    pseudo_objects
        Parameter of the weights' prior, positive.
    """

    counts: Array
    possible: NDArray[np.bool_]
    pseudo_looks: Array
    pseudo_objects: float

    def expectation(self, mixture: Mixture) -> tuple[Array, Array]:
        """Return the posterior of each object's mode, (S, n, M), and each start's log-likelihood, (S,)."""
        n = len(self.counts)
        looks = self.counts.reshape(n, -1)  # (n, T * Z)
        tables = np.log(mixture.tables).reshape(*mixture.weights.shape, looks.shape[1])  # (S, M, T * Z)
        joint = looks @ tables.swapaxes(1, 2) + np.log(mixture.weights)[:, None]  # (S, n, M)
        joint[:, ~self.possible] = -np.inf
        evidence = logsumexp(joint, axis=2, keepdims=True)
        return np.exp(joint - evidence), evidence.sum(axis=(1, 2))

    def maximisation(self, posterior: Array) -> Mixture:
        """Return the mixture that maximises the expected penalised log-likelihood."""
        n, rows, labels = self.counts.shape
        tables = posterior.swapaxes(1, 2) @ self.counts.reshape(n, -1)  # (S, M, T * Z)
        tables = tables.reshape(*tables.shape[:2], rows, labels) + self.pseudo_looks
        weights = posterior.sum(axis=1) + self.pseudo_objects
        return Mixture(
            weights / weights.sum(axis=-1, keepdims=True), tables / tables.sum(axis=-1, keepdims=True)
        )

    def penalty(self, mixture: Mixture) -> Array:
        """Return the logarithm of the prior density of each start but for a constant, shape (S,)."""
        of_tables: Array = (self.pseudo_looks * np.log(mixture.tables)).sum(axis=(1, 2, 3))
        of_weights: Array = self.pseudo_objects * np.log(mixture.weights).sum(axis=1)
        return of_tables + of_weights

    def iterate(self, mixture: Mixture) -> tuple[Mixture, Array]:
        """Return the mixture after one iteration, and the penalised log-likelihood before it, shape (S,)."""
        posterior, likelihood = self.expectation(mixture)
        return self.maximisation(posterior), likelihood + self.penalty(mixture)

    def maximise(self, mixture: Mixture) -> tuple[Mixture, Array]:
        """Iterate until every start has converged; return the mixture and its penalised log-likelihood."""
        value = np.full(len(mixture.weights), -np.inf)
        for _ in range(MOST_ITERATIONS):
            following, reached = self.iterate(mixture)
            if np.all(reached - value <= TOLERANCE * len(self.counts)):
                break
            mixture, value = following, reached
        return mixture, reached

    def without(self, modes: NDArray[np.int64]) -> Self:
        """Return the problem with these modes only."""
        prior = self.pseudo_looks if self.pseudo_looks.ndim == 2 else self.pseudo_looks[modes]
        return replace(self, possible=self.possible[:, modes], pseudo_looks=prior)
