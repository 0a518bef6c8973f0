"""Tests of independence: they find what is there, and rarely what is not."""

from itertools import product

import numpy as np
import pytest

from beltsort.tables import independence as module
from beltsort.tables.independence import (
    NEIGHBOUR,
    REPEAT,
    TWO_LABELS,
    IndependenceTest,
    holm,
    independence,
    repetition_p_value,
)
from beltsort.tables.repeated_looks import RepeatedLooks
from beltsort.tables.scans import LabelledScan
from tests.tables.planted import P_OBS, SHAPE, planted, planted_objects

CLASSES = 3


def scans(
    seed: int, objects: int, *, together: float = 0.0, hidden: float = 0.0, repeat: float = 0.0
) -> list[LabelledScan]:
    """Draw two scans of each scene; the shares say how often an assumption is broken."""
    rng = np.random.default_rng(seed)

    def label(true: int) -> int:
        return true if rng.random() < 0.7 else int(rng.integers(CLASSES))

    def labels(first: int, second: int) -> list[int]:
        pair = [label(first), label(second)]
        if rng.random() < together:
            pair = [int(rng.integers(CLASSES))] * 2
        if rng.random() < hidden:
            pair[1] = first
        return pair

    drawn = []
    for number, viewpoint in product(range(objects), range(2)):
        true = tuple(int(c) for c in rng.integers(CLASSES, size=2))
        names = tuple(f"{viewpoint} {number} {j}" for j in range(2))
        once, again = labels(*true), labels(*true)
        again = [a if rng.random() < repeat else b for a, b in zip(once, again, strict=True)]
        drawn += [LabelledScan(viewpoint, true, names, tuple(seen)) for seen in (once, again)]
    return drawn


def smallest(tests: list[IndependenceTest], assumption: str) -> float:
    return min(test.p for test in tests if test.assumption == assumption)


@pytest.mark.parametrize(
    ("broken", "assumption"), [("together", TWO_LABELS), ("hidden", NEIGHBOUR), ("repeat", REPEAT)]
)
def test_what_depends_is_found(broken: str, assumption: str) -> None:
    shares: dict[str, float] = {broken: 0.3}
    tests = independence(scans(0, 200, **shares))
    found = [test for test in tests if test.assumption == assumption]
    assert len(found) == {TWO_LABELS: 2, NEIGHBOUR: 4, REPEAT: 4}[assumption]
    assert smallest(tests, assumption) < 0.01
    assert max(test.excess for test in found) > 0.04
    for other in {TWO_LABELS, NEIGHBOUR, REPEAT} - {assumption}:
        assert smallest(tests, other) > 0.01


@pytest.mark.slow
def test_independence_is_rarely_rejected(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "PERMUTATIONS", 99)
    runs = [independence(scans(seed, objects=20), seed) for seed in range(100)]
    for assumption in (TWO_LABELS, NEIGHBOUR, REPEAT):
        rejected = sum(smallest(tests, assumption) <= 0.05 for tests in runs)
        assert rejected <= 12  # of 100 at 0.05; more with probability 0.0015


def test_the_seed_is_all_that_chance_depends_on() -> None:
    drawn = scans(1, objects=30)
    assert independence(drawn, seed=4) == independence(drawn, seed=4)


def test_p_is_exact_where_all_permutations_can_be_counted() -> None:
    # Two objects of each of four classes, each scanned twice alike: a class agrees by chance in half of
    # the exchanges, all of them in one of sixteen.
    drawn = [
        LabelledScan(0, (true,), (f"{true} {label}",), (label,))
        for true in range(4)
        for label in range(2)
        for _ in range(2)
    ]
    (test,) = independence(drawn)
    assert (test.assumption, test.scans, test.positions) == (REPEAT, 8, (0,))
    assert test.p == pytest.approx(1 / 16, abs=0.022)  # four standard errors
    assert test.excess == pytest.approx(0.5, abs=0.02)


def test_scans_without_labels_tell_nothing() -> None:
    blind = [LabelledScan(0, (0, 1), (f"a{i}", f"b{i}"), (None, None)) for i in range(5)]
    assert independence(blind) == []
    assert independence([]) == []


def test_holm() -> None:
    tests = [IndependenceTest(REPEAT, k, (0,), 10, 0.1, p) for k, p in enumerate([0.04, 0.01, 0.03, 0.8])]
    assert [test.p for test in holm(tests)] == pytest.approx([0.09, 0.04, 0.09, 0.8])


def test_independent_looks_are_rarely_taken_to_repeat_each_other() -> None:
    """Under independence p is uniform, so below 0.1 in a tenth of the samples."""
    alike = P_OBS[:, :, [0, 0, 2, 2]]
    p = [
        repetition_p_value(RepeatedLooks.of(planted_objects(24, scans=2, seed=seed, p_obs=alike), SHAPE))
        for seed in range(40)
    ]
    assert 0 <= np.count_nonzero(np.array(p) < 0.1) <= 10
    assert 0.3 < np.mean(p) < 0.7


def test_looks_at_planted_modes_repeat_each_other() -> None:
    assert repetition_p_value(planted(120, scans=2)) < 0.01
