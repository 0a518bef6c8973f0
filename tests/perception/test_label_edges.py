"""Where the score of confidence is cut."""

from itertools import combinations
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

import beltsort
from beltsort.errors import DatabaseError
from beltsort.perception import Match, fit_label_rule, leave_one_out
from beltsort.perception.label_edges import PARTS, informative_edges, quantile_edges
from tests.laws import cases
from tests.perception.databases import CLASSES, database

SCORES = st.lists(st.floats(-1.0, 1.0) | st.sampled_from([0.0, 0.5, 1.0]), min_size=1, max_size=40).map(
    np.array
)


def levels_of(scores: NDArray[np.float64], edges: tuple[float, ...]) -> NDArray[np.int64]:
    return np.searchsorted(edges, scores, side="right")


@given(SCORES, st.integers(1, 4))
def test_every_level_between_quantiles_has_scores(scores: NDArray[np.float64], levels: int) -> None:
    edges = quantile_edges(scores, levels)
    assert len(edges) < levels
    assert list(edges) == sorted(set(edges))
    assert set(levels_of(scores, edges)) == set(range(len(edges) + 1))


@given(st.integers(4, 60), st.integers(1, 4), st.randoms(use_true_random=False))
def test_different_scores_are_shared_equally(n: int, levels: int, random: Any) -> None:
    scores = np.array(random.sample(range(1000), n)) / 1000.0
    sizes = np.bincount(levels_of(scores, quantile_edges(scores, levels)), minlength=levels)
    assert sizes.max() - sizes.min() <= 1


@given(SCORES.filter(lambda scores: len(set(scores.tolist())) > 1), st.integers(2, 4))
def test_different_scores_make_levels(scores: NDArray[np.float64], levels: int) -> None:
    assert quantile_edges(scores, levels)


def test_neighbouring_numbers_are_kept_apart() -> None:
    scores = np.array([1.0, np.nextafter(1.0, 2.0)])
    assert levels_of(scores, quantile_edges(scores, 2)).tolist() == [0, 1]


def information(labels: NDArray[np.int64], true: NDArray[np.int64]) -> float:
    """Return the mutual information, nats."""
    joint = np.zeros((labels.max() + 1, true.max() + 1))
    np.add.at(joint, (labels, true), 1.0 / len(labels))
    independent = np.outer(joint.sum(axis=1), joint.sum(axis=0))
    seen = joint > 0.0
    return float((joint[seen] * np.log(joint[seen] / independent[seen])).sum())


def looks(seed: int, n: int = 40) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.int64]]:
    """Draw labels that are right the more often, the larger the score."""
    rng = np.random.default_rng(seed)
    scores, true = rng.random(n), rng.integers(3, size=n)
    labels = np.where(rng.random(n) < scores, true, rng.integers(3, size=n))
    return scores, labels, true


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("levels", [1, 2, 3, 4])
def test_no_other_edges_tell_more_of_the_class(seed: int, levels: int) -> None:
    scores, labels, true = looks(seed)

    def told(edges: tuple[float, ...]) -> float:
        return information(labels * 4 + levels_of(scores, edges), true)

    possible = combinations(quantile_edges(scores, PARTS), levels - 1)
    best = informative_edges(scores, labels, true, levels)
    assert told(best) == pytest.approx(max(map(told, possible)))


@cases(30)
@given(st.integers(0, 10**6), st.permutations(range(3)))
def test_names_of_classes_do_not_move_edges(seed: int, order: list[int]) -> None:
    scores, labels, true = looks(seed)
    again = informative_edges(scores, np.array(order)[labels], np.array(order)[true], 2)
    told = [
        information(labels * 4 + levels_of(scores, e), true)
        for e in (informative_edges(scores, labels, true, 2), again)
    ]
    assert told[0] == pytest.approx(told[1])


def test_equal_scores_make_one_level() -> None:
    scores, labels, true = looks(0)
    assert informative_edges(np.full_like(scores, 0.5), labels, true, 3) == ()
    assert quantile_edges(np.full_like(scores, 0.5), 3) == ()


def test_levels_where_the_labels_turn_reliable() -> None:
    scores = np.arange(100) / 100.0
    true = np.arange(100) % 2
    labels = np.where(scores < 0.7, 1, true)
    assert informative_edges(scores, labels, true, 2) == pytest.approx((0.695,))


@pytest.mark.parametrize("method", ["quantiles", "information"])
def test_a_rule_is_fitted_by_leaving_one_out(method: Any) -> None:
    trained = database(n=60)
    left_out = leave_one_out(trained)
    rule = fit_label_rule(CLASSES, left_out, trained.labels, 3, method=method, not_recognised=True)
    assert rule.levels == 3
    assert rule.not_recognised
    assert {rule.label(match) for match in left_out} <= set(range(9))
    rejected = [Match(None, match.scores, match.distances) for match in left_out[:5]]
    again = fit_label_rule(
        CLASSES, [*left_out, *rejected], [*trained.labels, *[0] * 5], 3, method=method, not_recognised=True
    )
    assert again == rule, "rejected ones are not used"


def test_one_level_needs_no_matches_and_no_distances() -> None:
    assert fit_label_rule(CLASSES, [], [], 1).labels == tuple(CLASSES)
    assert fit_label_rule(CLASSES, [Match(0, np.ones(3))], [0], 1).edges == ()


@pytest.mark.parametrize("levels", [0, 5, 2.0, True])
def test_a_senseless_number_of_levels_is_refused(levels: Any) -> None:
    with pytest.raises(beltsort.ArgumentError, match=rf"\blevels\b.*{levels}\b.*\b1\b.*\b4\b"):
        fit_label_rule(CLASSES, [], [], levels)


def test_what_cannot_be_fitted_is_refused() -> None:
    with pytest.raises(beltsort.ArgumentError, match=r"\bmethod\b.*'mean'.*'quantiles'.*'information'"):
        fit_label_rule(CLASSES, [], [], 2, method="mean")  # type: ignore[arg-type]  # the mistake under test
    with pytest.raises(beltsort.ArgumentError, match=r"\b0 matches\b"):
        fit_label_rule(CLASSES, [Match(None, np.ones(3), np.ones(3))], [0])
    with pytest.raises(DatabaseError, match=r"\bdistances\b"):
        fit_label_rule(CLASSES, [Match(0, np.ones(3))], [0])
    with pytest.raises(ValueError, match="zip"):
        fit_label_rule(CLASSES, [Match(0, np.ones(3), np.ones(3))], [])
