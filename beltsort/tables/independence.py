r"""Test whether labels are as independent as the model takes them to be.

Three assumptions are tested on labelled scans: given their classes, the labels of two positions do not depend
on each other; a label does not depend on the class at another position; and two scans of one object from one
viewpoint agree no more often than scans of two objects of its class. (A model with `repeat` does not make the
third assumption.)

Each test is a permutation test within strata of equal class: under the assumption, labels may be exchanged
among the scans of a stratum. So its p-values are exact, however few scans there are.

References
----------
G-test: R. R. Sokal, F. J. Rohlf, "Biometry", W. H. Freeman. Permutation p-values: B. Phipson, G. K. Smyth,
"Permutation p-values should never be zero", Stat. Appl. Genet. Mol. Biol. 9 (2010). Several tests at once:
S. Holm, "A simple sequentially rejective multiple test procedure", Scand. J. Stat. 6 (1979).
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, permutations

import numpy as np
from numpy.typing import NDArray

from beltsort.tables.repeated_looks import NONE, RepeatedLooks
from beltsort.tables.scans import LabelledScan, first_of_each_scene, looks
from beltsort.util.extras import extra

with extra("perception"):
    from scipy.special import xlogy

Integers = NDArray[np.int64]
Statistic = Callable[[Integers], float]

PERMUTATIONS = 1999
TWO_LABELS, NEIGHBOUR, REPEAT = "labels of two positions", "label and neighbour's class", "repeated scans"


@dataclass(frozen=True)
class IndependenceTest:
    """The test of one assumption with the scans from one viewpoint.

    Attributes
    ----------
    assumption
        `TWO_LABELS`, `NEIGHBOUR` or `REPEAT`.
    viewpoint
        Index.
    positions
        Indices: the two positions, the position of the label and its neighbour's, or the one position.
    scans
        Scans, or scanned objects, that were compared.
    excess
        By how much the statistic exceeds its mean under independence, per scan: information in nats, for
        `REPEAT` the share of agreements.
    p
        Probability of such an excess if the assumption holds, Holm-corrected over the tests of this
        assumption.
    """

    assumption: str
    viewpoint: int
    positions: tuple[int, ...]
    scans: int
    excess: float
    p: float


def independence(scans: Iterable[LabelledScan], seed: int = 0) -> list[IndependenceTest]:
    """Test the three assumptions at every viewpoint.

    Parameters
    ----------
    scans
        Labelled scans; those without a label at a position are not used for it.
    seed
        Of the permutations.

    Returns
    -------
    list
        Tests in the order of assumption, viewpoint and positions, without those that have nothing to compare.
    """
    every = list(scans)
    once = first_of_each_scene(every)
    rng = np.random.default_rng(seed)
    families = [list(_two_labels(once, rng)), list(_neighbour(once, rng)), list(_repeat(every, rng))]
    return [test for family in families for test in holm(family)]


def holm(tests: Sequence[IndependenceTest]) -> list[IndependenceTest]:
    """Correct p-values for the number of tests by Holm's step-down procedure."""
    corrected, least = list(tests), 0.0
    for rank, i in enumerate(sorted(range(len(tests)), key=lambda i: tests[i].p)):
        least = max(least, min(1.0, (len(tests) - rank) * tests[i].p))
        corrected[i] = replace(tests[i], p=least)
    return corrected


def _two_labels(scans: list[LabelledScan], rng: np.random.Generator) -> Iterator[IndependenceTest]:
    for k in _viewpoints(scans):
        for i, j in combinations(_positions(scans), 2):
            rows = [
                ((scan.true[i], scan.true[j]), scan.observed[i], scan.observed[j])
                for scan in scans
                if scan.viewpoint == k
            ]
            yield from _test(TWO_LABELS, k, (i, j), rows, information, rng)


def _neighbour(scans: list[LabelledScan], rng: np.random.Generator) -> Iterator[IndependenceTest]:
    for k in _viewpoints(scans):
        for i, j in permutations(_positions(scans), 2):
            rows = [
                ((scan.true[i],), scan.observed[i], scan.true[j]) for scan in scans if scan.viewpoint == k
            ]
            yield from _test(NEIGHBOUR, k, (i, j), rows, information, rng)


def _repeat(scans: list[LabelledScan], rng: np.random.Generator) -> Iterator[IndependenceTest]:
    seen = list(looks(scans))
    for k in _viewpoints(scans):
        for j in _positions(scans):
            rows = [
                ((look.true,), look.observed, look.again)
                for look in seen
                if (look.viewpoint, look.position) == (k, j)
            ]
            yield from _test(REPEAT, k, (j,), rows, agreements, rng)


def _viewpoints(scans: list[LabelledScan]) -> list[int]:
    return sorted({scan.viewpoint for scan in scans})


def _positions(scans: list[LabelledScan]) -> range:
    return range(len(scans[0].true) if scans else 0)


def _test(
    assumption: str,
    viewpoint: int,
    positions: tuple[int, ...],
    rows: Sequence[tuple[tuple[int | None, ...], int | None, int | None]],
    statistic: Statistic,
    rng: np.random.Generator,
) -> Iterator[IndependenceTest]:
    """Yield the test, its p-value not corrected yet, if there are two scans to exchange."""
    complete = [row for row in rows if None not in (*row[0], *row[1:])]
    if len(complete) < 2:
        return
    strata = np.unique([row[0] for row in complete], axis=0, return_inverse=True)[1].reshape(-1)
    a, b = (np.array([row[side] for row in complete], dtype=np.int64) for side in (1, 2))
    excess, p = permutation_test(strata, a, b, statistic, rng)
    yield IndependenceTest(assumption, viewpoint, positions, len(complete), excess / len(complete), p)


def permutation_test(
    strata: Integers, a: Integers, b: Integers, statistic: Statistic, rng: np.random.Generator
) -> tuple[float, float]:
    """Permute `b` within strata; return the excess of the statistic over its mean, and the p-value.

    Parameters
    ----------
    strata, a, b
        Indices, shape (n,) each.
    statistic
        Of the contingency tables, shape (strata, labels, labels).
    rng
        Draws the permutations.
    """
    order = np.argsort(strata, kind="stable")
    strata, a, b = strata[order], a[order], b[order]
    labels = int(max(a.max(), b.max())) + 1
    shape = (int(strata.max()) + 1, labels, labels)

    def value(exchanged: Integers) -> float:
        cells = np.ravel_multi_index((strata, a, exchanged), shape)
        return statistic(np.bincount(cells, minlength=int(np.prod(shape))).reshape(shape))

    seen = value(b)
    drawn = np.array([value(b[np.lexsort((rng.random(len(b)), strata))]) for _ in range(PERMUTATIONS)])
    as_large = int((drawn >= seen - 1e-9 * abs(seen)).sum())
    return float(seen - drawn.mean()), (1 + as_large) / (1 + PERMUTATIONS)


def repetition_p_value(looks: RepeatedLooks, seed: int = 0) -> float:
    """Return the p-value of the looks at an object agreeing no more often than looks at others of its class.

    The looks of all viewpoints and positions count. Labels are permuted among the looks of a table row, which
    leaves how often each label is seen there.

    Examples
    --------
    >>> from beltsort.tables.repeated_looks import LooksAtObject, TableShape
    >>> stuck = [LooksAtObject(true=0, looks=((0, 0, n % 2),) * 4) for n in range(8)]
    >>> mixed = [LooksAtObject(true=0, looks=((0, 0, 0), (0, 0, 1)) * 2) for n in range(8)]
    >>> shape = TableShape(positions=1, viewpoints=1, classes=1, labels=2)
    >>> [repetition_p_value(RepeatedLooks.of(each, shape)) for each in (stuck, mixed)]
    [0.0005, 1.0]
    """
    seen = looks.labels != NONE
    objects, labels = looks.objects[seen], looks.labels[seen]
    shape = looks.shape
    rows = np.ravel_multi_index(
        (looks.true[objects], looks.positions[seen], looks.viewpoints[seen]),
        (shape.classes, shape.positions, shape.viewpoints),
    )
    order = np.argsort(rows, kind="stable")
    rows, objects, labels = rows[order], objects[order], labels[order]

    def agreeing(permuted: Integers) -> int:
        """Return the sum of squares of how often each label was seen at each object."""
        return int((np.bincount(objects * shape.labels + permuted) ** 2).sum())

    rng = np.random.default_rng(seed)
    drawn = (agreeing(labels[np.lexsort((rng.random(len(rows)), rows))]) for _ in range(PERMUTATIONS))
    threshold = agreeing(labels)
    return (1 + sum(value >= threshold for value in drawn)) / (1 + PERMUTATIONS)


def information(tables: Integers) -> float:
    """Return half the G statistic up to a constant: permutations do not change the margins."""
    return float(xlogy(tables, tables).sum())


def agreements(tables: Integers) -> float:
    """Return the number of pairs that agree."""
    return float(np.einsum("sii->", tables))
