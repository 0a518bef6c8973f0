r"""How much looks at one object depend on each other, given its class.

The looks at an object are those as the belt carries it from the last position to the belt end: two scans from
every viewpoint at every position.

Pairs of looks are of four kinds: from one or from two viewpoints, before and after the belt has moved or at
one position. For each kind,

.. math:: \text{repeated} = \frac{\text{agreement} - \text{chance}}{1 - \text{chance}},

where agreement is the share of pairs of looks at one object whose labels agree, and chance is that share for
looks at two objects of one class. It generalises the model's `repeat` to every kind of pair. It is 0 where
looks are independent, which the model assumes except for repeated looks at one position. Also measured: how
often both labels are wrong, and how often they would be if looks were independent.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from beltsort.perception import Classifier
from beltsort.sim import CellConfig
from beltsort.sim.collect import SCANS, collect_scans
from beltsort.tables.repeated_looks import looks_at_objects
from beltsort.util.processes import Progress, at_least_one

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

NO_LABEL = -1
RESAMPLES = 300  # of the bootstrap


@dataclass(frozen=True, eq=False)
class ObjectLooks:
    """Labels of n objects, each scanned equally often from each of K viewpoints at each of H positions.

    Attributes
    ----------
    true
        Class indices, shape (n,).
    labels
        Shape (n, H, K, scans); `NO_LABEL` where there was none.
    """

    true: Integers
    labels: Integers


def collect_looks(
    database: Classifier,
    config: CellConfig | None = None,
    *,
    objects: int,
    seed: int = 0,
    workers: int | None = None,
    progress: Progress | None = None,
) -> ObjectLooks:
    """Scan objects of the simulated cell twice from every viewpoint at every position.

    Parameters
    ----------
    database
        The classifier.
    config
        What the cell is set to.
    objects
        Least number of objects; see `beltsort.sim.rounds.Passage`.
    seed, workers, progress
        As in `beltsort.sim.collect.collect_counts`.

    Raises
    ------
    ArgumentError
        If `objects` or `workers` is below 1.
    """
    config = config or CellConfig()
    of_each = -(-at_least_one("objects", objects) // len(config.classes))
    scans = collect_scans(
        database, config, objects=of_each, seed=seed, passages=True, workers=workers, progress=progress
    )
    looked = looks_at_objects(scans)
    shape = (len(looked), config.layout.positions, len(config.viewpoints), SCANS)
    labels, done = np.full(shape, NO_LABEL), np.zeros(shape[:-1], dtype=np.int64)
    for n, each in enumerate(looked):
        for j, k, label in each.looks:
            labels[n, j, k, done[n, j, k]] = NO_LABEL if label is None else label
            done[n, j, k] += 1
    return ObjectLooks(np.array([each.true for each in looked], dtype=np.int64), labels)


@dataclass(frozen=True)
class Dependence:
    """How much looks depend on each other, for one kind of pairs of looks.

    Attributes
    ----------
    same_viewpoint, same_position
        The kind.
    repeated, repeated_error
        The share defined above, and its standard error by a bootstrap of objects.
    both_wrong, both_wrong_expected
        Share of pairs whose labels are both wrong: observed, and expected if looks were independent given the
        class.
    """

    same_viewpoint: bool
    same_position: bool
    repeated: float
    repeated_error: float
    both_wrong: float
    both_wrong_expected: float


def dependences(looks: ObjectLooks, seed: int = 0) -> list[Dependence]:
    """Measure the dependence for each kind of pairs; kinds without a pair are left out.

    Parameters
    ----------
    looks
        Of at least two objects of each class.
    seed
        Of the bootstrap.
    """
    rng = np.random.default_rng(seed)
    n, positions, viewpoints, scans = looks.labels.shape
    position, viewpoint = np.indices((positions, viewpoints, scans))[:2].reshape(2, -1)
    labels = looks.labels.reshape(n, -1)
    classes = int(max(labels.max(), looks.true.max())) + 1
    # Shape (n, looks, L): a row of zeros where there is no label.
    one_hot: Array = (labels[:, :, np.newaxis] == np.arange(classes)).astype(np.float64)
    wrong = 1.0 - one_hot[np.arange(n), :, looks.true] - (one_hot.sum(axis=2) == 0)
    everything = _PairSums(one_hot, wrong, looks.true, np.ones(n))
    samples = [
        _PairSums(one_hot, wrong, looks.true, rng.multinomial(n, np.full(n, 1.0 / n)).astype(np.float64))
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


class _PairSums:
    """Sums over objects, with weights, for every pair of looks; each has the shape (looks, looks).

    The sums for chance are over pairs of a look at one object and a look at another object of its class.
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
        """Return the share of looks that only repeat the other look's label."""
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
