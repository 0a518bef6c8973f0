r"""How much looks at one object depend on each other, given its class.

Pairs of looks are of four kinds: from one or from two viewpoints, before and after the belt has moved or at
one position. For each kind,

.. math:: \text{repeated} = \frac{\text{agreement} - \text{chance}}{1 - \text{chance}},

agreement being the share of pairs of one object whose labels agree, chance that of pairs of two objects of
its class. So it is what `repeat` is, for every kind of pair: 0 where looks are independent, as the model has
it but for repeated looks at one position. Also: how often both labels are wrong, and how often they would be
if looks were independent.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from beltsort.calibration.portraits import Portraits

Array = NDArray[np.float64]

RESAMPLES = 300


@dataclass(frozen=True)
class Dependence:
    """What one kind of pairs of looks says.

    Attributes
    ----------
    same_viewpoint, same_position
        The kind.
    repeated, repeated_error
        See above, and its standard error by a bootstrap of objects.
    both_wrong, both_wrong_expected
        Share of pairs of which both labels are wrong: seen, and if looks were independent given the class.
    """

    same_viewpoint: bool
    same_position: bool
    repeated: float
    repeated_error: float
    both_wrong: float
    both_wrong_expected: float


def dependences(portraits: Portraits, seed: int = 0) -> list[Dependence]:
    """Measure the dependence of all kinds of pairs; kinds that have none are left out.

    Parameters
    ----------
    portraits
        At least two of each class.
    seed
        Of the bootstrap.
    """
    rng = np.random.default_rng(seed)
    n, positions, viewpoints, scans = portraits.labels.shape
    position, viewpoint = np.indices((positions, viewpoints, scans))[:2].reshape(2, -1)
    one_hot = _one_hot(portraits)
    wrong = 1.0 - one_hot[np.arange(n), :, portraits.true] - (one_hot.sum(axis=2) == 0)
    everything = _Weighted(one_hot, wrong, portraits.true, np.ones(n))
    samples = [
        _Weighted(one_hot, wrong, portraits.true, rng.multinomial(n, np.full(n, 1.0 / n)).astype(np.float64))
        for _ in range(RESAMPLES)
    ]
    found = []
    for same_viewpoint, same_position in ((True, True), (False, True), (True, False), (False, False)):
        kind = (position == position[:, np.newaxis]) == same_position
        kind &= (viewpoint == viewpoint[:, np.newaxis]) == same_viewpoint
        np.fill_diagonal(kind, False)
        if kind.any():
            error = float(np.std([sample.repeated(kind) for sample in samples]))
            repeated = everything.repeated(kind)
            wrongs = everything.both_wrong(kind)
            found.append(Dependence(same_viewpoint, same_position, repeated, error, *wrongs))
    return found


def _one_hot(portraits: Portraits) -> Array:
    """Return labels as rows of one 1, all 0 where there is none, shape (n, looks, L)."""
    labels = portraits.labels.reshape(len(portraits.labels), -1)
    classes = int(max(labels.max(), portraits.true.max())) + 1
    one_hot: Array = (labels[:, :, np.newaxis] == np.arange(classes)).astype(np.float64)
    return one_hot


class _Weighted:
    """Sums over weighted objects, shape (looks, looks) each: every look with every other.

    Chance pairs a look of one object with a look of another object of its class.
    """

    def __init__(self, one_hot: Array, wrong: Array, true: NDArray[np.int64], weights: Array) -> None:
        looks = one_hot.shape[1]
        shape = (looks, looks)
        self._agree, self._wrong, self._pairs = np.zeros(shape), np.zeros(shape), np.zeros(shape)
        self._chance_agree, self._chance_wrong = np.zeros(shape), np.zeros(shape)
        for label in np.unique(true):
            w = weights[true == label]
            x, e = one_hot[true == label], wrong[true == label]
            seen = x.sum(axis=2)
            pairs = np.einsum("o,oa,ob->ab", w, seen, seen)
            others = np.maximum(_others(seen[:, :, np.newaxis], w), 1.0)  # 0 if all is one object
            self._pairs += pairs
            self._agree += np.einsum("o,oaz,obz->ab", w, x, x, optimize=True)
            self._wrong += np.einsum("o,oa,ob->ab", w, e, e)
            self._chance_agree += pairs * _others(x, w) / others
            self._chance_wrong += pairs * _others(e[:, :, np.newaxis], w) / others

    def repeated(self, kind: NDArray[np.bool_]) -> float:
        """Return the share of looks that only repeat."""
        agreement, chance = (sums[kind].sum() for sums in (self._agree, self._chance_agree))
        return float((agreement - chance) / (self._pairs[kind].sum() - chance))

    def both_wrong(self, kind: NDArray[np.bool_]) -> tuple[float, float]:
        """Return how often both looks are wrong, and how often those of two objects are."""
        pairs = self._pairs[kind].sum()
        return float(self._wrong[kind].sum() / pairs), float(self._chance_wrong[kind].sum() / pairs)


def _others(x: Array, weights: Array) -> Array:
    """Sum the products of rows of two different objects, shape (looks, looks)."""
    sums = np.einsum("o,oaz->az", weights, x)
    own = np.einsum("o,oaz,obz->ab", weights**2, x, x, optimize=True)
    products: Array = sums @ sums.T - own
    return products
