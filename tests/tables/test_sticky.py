"""Sticky labels: the likelihood is that of all combinations, and both probabilities are found."""

from itertools import product

import numpy as np
import pytest

from beltsort.tables.repeated_looks import LooksAtObject, RepeatedLooks
from beltsort.tables.sticky import StickyLabels, fit_sticky_labels
from tests.tables.planted import P_OBS, SHAPE, planted

TABLES = StickyLabels(P_OBS[:, :, [0, 2]], sticky=0.4, shared=0.3)


def brute_force(looks: tuple[tuple[int, int, int], ...], label: int) -> float:
    """Sum over the common label and the sticky label of each viewpoint, as the formula reads."""
    table = TABLES.p_obs[:, :, label]
    of_viewpoint = table.mean(axis=0)
    total = 0.0
    for common, *own in product(range(3), repeat=3):
        p = of_viewpoint.mean(axis=0)[common]
        for k, m in enumerate(own):
            p *= TABLES.shared * (m == common) + (1 - TABLES.shared) * of_viewpoint[k, m]
        for j, k, z in looks:
            p *= TABLES.sticky * (z == own[k]) + (1 - TABLES.sticky) * table[j, k, z]
        total += p
    return float(total)


LOOKS = ((0, 0, 1), (1, 0, 1), (0, 1, 2), (1, 1, 0), (0, 0, 1), (0, 1, 2))


def test_likelihood_is_that_of_brute_force() -> None:
    one = RepeatedLooks.of([LooksAtObject(0, LOOKS)], SHAPE)
    expected = [np.log(brute_force(LOOKS, label)) for label in range(2)]
    np.testing.assert_allclose(TABLES.log_likelihoods(one)[0], expected, rtol=1e-12)


def test_likelihoods_sum_to_one() -> None:
    rows = [(0, 0), (1, 0), (0, 1)]
    every = [
        LooksAtObject(0, tuple((*row, z) for row, z in zip(rows, labels, strict=True)))
        for labels in product(range(3), repeat=3)
    ]
    likelihoods = np.exp(TABLES.log_likelihoods(RepeatedLooks.of(every, SHAPE)))
    np.testing.assert_allclose(likelihoods.sum(axis=0), 1.0)


def test_as_modes_is_the_same_distribution() -> None:
    looks = planted(50, scans=2)
    modes = TABLES.as_modes()
    assert modes.kinds == TABLES.kinds == 2 * 3**2
    np.testing.assert_allclose(modes.log_likelihoods(looks), TABLES.log_likelihoods(looks), rtol=1e-10)


def test_nothing_sticky_is_independence() -> None:
    looks = planted(30, scans=2)
    independent = StickyLabels(TABLES.pseudo_counts, 0.0, 0.5)
    expected = np.einsum("njkz,jkcz->nc", looks.counts(), np.log(TABLES.p_obs))
    np.testing.assert_allclose(independent.log_likelihoods(looks), expected, rtol=1e-12)


def test_both_probabilities_are_found() -> None:
    rng = np.random.default_rng(4)
    modes = TABLES.as_modes()
    objects = []
    for n in range(1200):
        true = n % 2
        kind = int(rng.choice(9, p=np.array(modes.weights[true]) / sum(modes.weights[true]))) + 9 * true
        rows = [(j, k) for j in range(2) for k in range(2) for _ in range(3)]
        drawn = modes.p_obs[:, :, kind]
        looks = tuple((j, k, int(rng.choice(3, p=drawn[j, k]))) for j, k in rows)
        objects.append(LooksAtObject(true, looks))
    found = fit_sticky_labels(RepeatedLooks.of(objects, SHAPE))
    assert found.sticky == pytest.approx(TABLES.sticky, abs=0.04)
    assert found.shared == pytest.approx(TABLES.shared, abs=0.1)
