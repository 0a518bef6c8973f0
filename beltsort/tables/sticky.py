r"""Looks that repeat a label of the object's own: two parameters instead of latent modes.

Every object has a *sticky label* :math:`m_k` for each viewpoint, drawn once. A look returns it with
probability s, and otherwise a fresh label from the class's table. The sticky labels of one object may agree,
too: with probability t, that of a viewpoint is one label g common to all of them, otherwise it is drawn from
the viewpoint's table. With :math:`p_{jk}` the class's table at position j and viewpoint k, :math:`q_k` its
mean over positions, q the mean of :math:`q_k` over viewpoints, and labels :math:`z_i` seen at
:math:`(j_i, k_i)`,

.. math::
    P(z \mid c) &= \sum_g q(g) \prod_k \sum_m [t \, 1(m = g) + (1 - t) \, q_k(m)] \, A_k(m), \\
    A_k(m) &= \prod_{i:\, k_i = k} [s \, 1(z_i = m) + (1 - s) \, p_{j_i k}(z_i)].

At s = 0 looks are independent. Taken alone, a label has the distribution of the class's table up to s times
what distinguishes positions, and s t times what distinguishes viewpoints.

References
----------
J. Velez, G. Hemann, A. S. Huang, I. Posner, N. Roy, "Modelling observation correlations for active
exploration and robust object detection", J. Artif. Intell. Res. 44 (2012): looks that copy earlier ones.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np

from beltsort.tables.counts import check_smoothing
from beltsort.tables.modes import ModeTables
from beltsort.tables.repeated_looks import Array, RepeatedLooks
from beltsort.util.defaults import UNIFORM_PRIOR
from beltsort.util.extras import extra

with extra("perception"):
    from scipy.special import logsumexp

MOST = 0.999  # of both probabilities: at 1, two looks that differ would be impossible
STARTS = ((0.2, 0.2), (0.5, 0.1), (0.5, 0.8))


@dataclass(frozen=True, eq=False)
class StickyLabels:
    """Tables of classes with sticky labels.

    Attributes
    ----------
    pseudo_counts
        Of the classes' tables, shape (H, K, L, Z).
    sticky
        Probability s that a look returns the object's sticky label of the viewpoint.
    shared
        Probability t that this label is the one common to all viewpoints.
    """

    pseudo_counts: Array
    sticky: float
    shared: float

    @property
    def p_obs(self) -> Array:
        """The classes' tables, shape (H, K, L, Z)."""
        tables: Array = self.pseudo_counts / self.pseudo_counts.sum(axis=-1, keepdims=True)
        return tables

    @property
    def kinds(self) -> int:
        """Number of kinds of `as_modes`: a planner's belief has no fewer."""
        _, viewpoints, classes, labels = self.pseudo_counts.shape
        return int(classes * labels**viewpoints)

    def log_likelihoods(self, looks: RepeatedLooks) -> Array:
        """Return the logarithm of the probability of each object's labels given each class, (n, L)."""
        counts = looks.counts().astype(np.float64)
        tables = self.p_obs
        by_class = [
            _log_likelihood(counts, tables[:, :, label], self.sticky, self.shared)
            for label in range(tables.shape[2])
        ]
        return np.stack(by_class, axis=1)

    def as_modes(self) -> ModeTables:
        """Return the same distribution as modes: one for each combination of sticky labels, Z ** K a class.

        The pseudo-counts have the right proportions only: modes that are not fitted have no errors.
        """
        tables = self.p_obs
        _, viewpoints, classes, labels = tables.shape
        combinations = np.array(list(product(range(labels), repeat=viewpoints)))  # (M, K)
        stuck = np.eye(labels)[combinations].swapaxes(0, 1)  # (K, M, Z)
        weights, kinds = [], []
        for label in range(classes):
            own = tables[:, :, label]  # (H, K, Z)
            of_viewpoint, common = _sticky_distributions(own)
            drawn = self.shared * np.eye(labels)[:, None] + (1.0 - self.shared) * of_viewpoint  # (g, K, m)
            chosen = drawn[:, np.arange(viewpoints), combinations].prod(axis=-1)  # (g, M)
            weights.append(tuple((common @ chosen).tolist()))
            kinds.append(self.sticky * stuck + (1.0 - self.sticky) * own[:, :, None])
        return ModeTables(
            tuple(weights),
            np.concatenate(kinds, axis=2),
            np.full(classes * len(combinations), np.nan),
            ((),) * classes,
        )


def fit_sticky_labels(looks: RepeatedLooks, smoothing: float | Array = UNIFORM_PRIOR) -> StickyLabels:
    """Fit both probabilities by maximum likelihood, with the classes' tables as `fit_modes` has them.

    Parameters
    ----------
    looks
        The looks.
    smoothing
        As in `Counts.probabilities`.

    Raises
    ------
    ArgumentError
        If `smoothing` is not positive.
    """
    with extra("perception"):
        from scipy.optimize import minimize  # 0.1 s that only this needs

    check_smoothing(smoothing, looks.shape.labels)
    pseudo_counts = looks.first_counts().astype(np.float64) + smoothing
    tables = StickyLabels(pseudo_counts, 0.0, 0.0).p_obs
    counts = looks.counts().astype(np.float64)
    groups = [(counts[looks.true == label], tables[:, :, label]) for label in np.unique(looks.true).tolist()]

    def cost(probabilities: Array) -> float:
        sticky, shared = probabilities.tolist()
        return -sum(float(_log_likelihood(*group, sticky, shared).sum()) for group in groups)

    fits = [minimize(cost, start, method="L-BFGS-B", bounds=[(0.0, MOST)] * 2) for start in STARTS]
    best = min(fits, key=lambda fit: float(fit.fun))
    sticky, shared = (float(probability) for probability in best.x)
    return StickyLabels(pseudo_counts, sticky, shared)


def _sticky_distributions(table: Array) -> tuple[Array, Array]:
    """Return the distributions of a class's sticky labels: of each viewpoint, (K, Z), and common, (Z,)."""
    of_viewpoint: Array = table.mean(axis=0)
    common: Array = of_viewpoint.mean(axis=0)
    return of_viewpoint, common


def _log_likelihood(counts: Array, table: Array, sticky: float, shared: float) -> Array:
    """Return the logarithm of the probability of each object's labels, shape (n,).

    Parameters
    ----------
    counts
        Shape (n, H, K, Z).
    table
        The class's, shape (H, K, Z).
    sticky, shared
        s and t.
    """
    of_viewpoint, common = _sticky_distributions(table)
    fresh = (1.0 - sticky) * table
    # log A_k(m): all labels as if fresh, and a correction for those that equal m.
    all_fresh = (counts * np.log(fresh)).sum(axis=(1, 3))  # (n, K)
    equal = (counts * (np.log(fresh + sticky) - np.log(fresh))).sum(axis=1)  # (n, K, m)
    stuck = all_fresh[:, :, None] + equal
    with np.errstate(divide="ignore"):
        log_shared, log_own = np.log(shared), np.log1p(-shared)
    own = log_own + logsumexp(np.log(of_viewpoint) + stuck, axis=2)  # (n, K)
    by_common = np.logaddexp(log_shared + stuck, own[:, :, None]).sum(axis=1)  # (n, g)
    result: Array = logsumexp(np.log(common) + by_common, axis=1)
    return result
