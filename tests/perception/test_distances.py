"""Distances of histograms: against their formulas, and as what a distance must be."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from beltsort.perception import distances
from beltsort.perception.distances import DISTANCES, distances_to

Values = NDArray[np.float64]


def chi2(a: Values, b: Values) -> float:
    both = a + b > 0.0
    return float(((a - b)[both] ** 2 / (a + b)[both]).sum())


FORMULAS: dict[str, Callable[[Values, Values], float]] = {
    "chi2": chi2,
    "l1": lambda a, b: float(np.abs(a - b).sum()),
    "l2": lambda a, b: float(np.linalg.norm(a - b)),
}


def histograms(n: int) -> Values:
    rng = np.random.default_rng(5)
    return rng.gamma(0.5, size=(n, 40)) * (rng.random((n, 40)) < 0.4)


@pytest.mark.parametrize("name", DISTANCES)
def test_as_the_formula_says_for_any_blocks(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    stored, asked = histograms(20), histograms(25)[20]
    expected = [FORMULAS[name](row, asked) for row in stored]
    for block in (1, 7, 20, 100):
        monkeypatch.setattr(distances, "BLOCK", block)
        assert distances_to(name, stored.T, asked).tolist() == pytest.approx(expected)


@pytest.mark.parametrize("name", DISTANCES)
def test_zero_to_itself_and_symmetric(name: str) -> None:
    stored = histograms(12)
    table = np.stack([distances_to(name, stored.T, row) for row in stored])
    assert (np.diagonal(table) == 0.0).all()
    assert (table + np.eye(12) > 0.0).all()
    np.testing.assert_allclose(table, table.T)


@pytest.mark.parametrize("name", DISTANCES)
def test_empty_histograms_are_no_special_case(name: str) -> None:
    assert distances_to(name, np.zeros((40, 2)), np.zeros(40)).tolist() == [0.0, 0.0]
