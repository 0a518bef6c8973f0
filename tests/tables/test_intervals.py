"""Standard errors, credible intervals, and what more objects would bring."""

from dataclasses import replace

import numpy as np
import pytest

from beltsort import ArgumentError
from beltsort.tables import Counts
from beltsort.tables.intervals import credible_intervals, objects_needed, standard_errors, worst_row


def counts_of(table: list[list[int]]) -> Counts:
    counts = np.array(table, dtype=np.int64)[None, None]
    none = np.zeros((1, 1), dtype=np.int64)
    return Counts(counts, np.zeros(counts.shape[:3], dtype=np.int64), none, none)


def test_the_interval_of_a_class_never_seen_has_a_closed_form() -> None:
    # Beta(1, n + 1) has the distribution function 1 - (1 - x)^(n + 1).
    lower, upper = credible_intervals(counts_of([[10, 0], [0, 10]]), smoothing=1.0)
    assert lower[0, 0, 0, 1] == pytest.approx(1 - 0.975 ** (1 / 11))
    assert upper[0, 0, 0, 1] == pytest.approx(1 - 0.025 ** (1 / 11))
    np.testing.assert_allclose(lower[0, 0, 0, 0], 1 - upper[0, 0, 0, 1])


def test_intervals_cover_the_truth_as_often_as_they_say() -> None:
    rng = np.random.default_rng(0)
    truth = rng.dirichlet([1.0, 1.0, 1.0], size=3000)  # drawn from the prior: coverage is exact
    counts = replace(counts_of([[0]]), counts=np.array([[[rng.multinomial(20, p) for p in truth]]]))
    lower, upper = credible_intervals(counts, smoothing=1.0)
    covered = ((lower <= truth) & (truth <= upper))[0, 0].mean(axis=0)
    np.testing.assert_allclose(covered, 0.95, atol=0.016)  # four standard errors


def test_standard_errors_are_the_posterior_s() -> None:
    errors = standard_errors(counts_of([[7, 2, 1]] * 3), smoothing=0.5)
    draws = np.random.default_rng(0).dirichlet([7.5, 2.5, 1.5], size=40_000)
    np.testing.assert_allclose(errors[0, 0, 0], draws.std(axis=0), rtol=0.02)


def test_the_objects_asked_for_are_enough_and_one_less_is_not() -> None:
    counts = counts_of([[30, 10], [2, 38]])
    more = objects_needed(counts, 1.0, wanted=0.04)
    assert worst_row(counts, 1.0, 0.04).missing == more.max() == more[0, 0, 0] > 0
    share = counts.probabilities(1.0)[0, 0, 0, 0]

    def error(objects: int) -> float:
        return float(np.sqrt(share * (1 - share) / (objects + 2 + 1)))

    assert error(40 + more[0, 0, 0]) <= 0.04 < error(40 + more[0, 0, 0] - 1)


def test_the_worst_row_is_named() -> None:
    counts = counts_of([[40, 0, 0], [20, 20, 0], [0, 0, 40]])
    worst = worst_row(counts, 1.0, wanted=0.1)
    assert (worst.position, worst.viewpoint, worst.true, worst.objects) == (0, 0, 1, 40)
    assert worst.error == standard_errors(counts, 1.0).max()
    assert worst.missing == 0


@pytest.mark.parametrize("wanted", [0.0, -1.0, 1.0, float("nan")])
def test_an_error_that_makes_no_sense(wanted: float) -> None:
    with pytest.raises(ArgumentError, match=rf"standard error\b.* {wanted}\b.*\b0\.03\b"):
        worst_row(counts_of([[1]]), 1.0, wanted)


def test_a_single_class_is_certain() -> None:
    lower, upper = credible_intervals(counts_of([[3]]), smoothing=1.0)
    assert lower.item() == upper.item() == 1.0
