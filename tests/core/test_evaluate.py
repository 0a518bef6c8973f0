"""evaluate: fair, reproducible, and honest about what it cannot say."""

from typing import Any

import numpy as np
import pytest

from beltsort import (
    ArgumentError,
    Belief,
    Despot,
    Evaluation,
    InformationGain,
    Move,
    SortingModel,
    Threshold,
    evaluate,
)

from .models import random_model, seeing_model
from .policies import Always, LookThenDecide, Recorded


def columns(result: Evaluation) -> list[list[float]]:
    arrays = (
        *(result.steps, result.correct, result.forced, result.returns, result.discounted_returns),
        *(result.expected_discounted_returns, result.bonuses, result.discounted_bonuses),
    )
    return [array.tolist() for array in arrays]


def test_independent_of_threads_and_repetition(paper: SortingModel) -> None:
    for policy in (Threshold(paper, 0.9), Despot(paper, trials=3, scenarios=50)):
        once = columns(evaluate(paper, policy, batches=20, seed=5, threads=1))
        for threads in (1, 2, 8, None):
            assert columns(evaluate(paper, policy, batches=20, seed=5, threads=threads)) == once
        assert columns(evaluate(paper, policy, batches=20, seed=6)) != once


def test_a_model_in_full_is_independent_of_threads(paper: SortingModel) -> None:
    model = SortingModel(
        *(paper.classes, paper.viewpoints, paper.p_obs),
        observe_after_decision=True,
        repeat=0.5,
        information_gain=0.5,
    )
    policy = InformationGain(model, 0.9, positions=2)
    once = columns(evaluate(model, policy, batches=20, threads=1))
    for threads in (2, 8):
        assert columns(evaluate(model, policy, batches=20, threads=threads)) == once


def test_more_batches_keep_the_first_ones(paper: SortingModel) -> None:
    policy = Threshold(paper, 0.9)
    few, many = (evaluate(paper, policy, batches=n) for n in (5, 9))
    assert many.returns[:5].tolist() == few.returns.tolist()


def test_every_policy_meets_the_same_objects() -> None:
    model = seeing_model(h=2, k=2)
    once, twice = LookThenDecide(0, looks=1), LookThenDecide(1, looks=2)
    for policy in (once, twice):
        assert evaluate(model, policy, batches=4).correct.tolist() == [10] * 4
    assert once.decided == twice.decided
    assert len(set(once.decided)) == 3


def test_the_nth_look_at_an_object_draws_the_same_random() -> None:
    table = random_model(0, h=1, k=1).p_obs
    twins = SortingModel(["a", "b", "c"], ["v", "w"], np.repeat(table, 2, axis=1))
    v, w = (columns(evaluate(twins, Threshold(twins, 0.8, viewpoint=p), batches=30)) for p in (0, 1))
    assert v == w


def test_returns_follow_from_steps_and_decisions(paper: SortingModel) -> None:
    result = evaluate(paper, InformationGain(paper, 0.9), batches=50)
    correct, steps = result.correct.astype(float), result.steps.astype(float)
    assert result.returns == pytest.approx(10 * correct - 50 * (10 - correct) - (steps - 10))


def test_discounting_by_hand() -> None:
    model = seeing_model(h=1, discount=0.5, motion_cost=2.0)
    result = evaluate(model, LookThenDecide(), batches=1, batch_size=2)
    expected = -2 + 10 * 0.5 - 2 * 0.25 + 10 * 0.125
    assert result.discounted_returns.tolist() == pytest.approx([expected])
    assert result.expected_discounted_returns.tolist() == pytest.approx([expected])
    assert result.returns.tolist() == [16.0]


def test_expected_returns_have_the_mean_of_the_realised_ones(paper: SortingModel) -> None:
    result = evaluate(paper, Threshold(paper, 0.8), batches=4000)
    difference = result.expected_discounted_returns - result.discounted_returns
    assert abs(difference.mean()) < 4 * difference.std() / np.sqrt(4000)
    assert result.expected_discounted_returns.std() < 0.5 * result.discounted_returns.std()


def test_true_classes_as_a_list() -> None:
    model = seeing_model()
    drawn = LookThenDecide()
    evaluate(model, drawn, batches=20, true_classes=[0, 2])
    assert set(drawn.decided) == {0, 2}
    assert 60 < drawn.decided.count(0) < 140


def test_true_classes_as_an_array() -> None:
    model = seeing_model(h=2)
    given = np.random.default_rng(0).integers(3, size=(4, 11))
    policy = LookThenDecide()
    evaluate(model, policy, batches=4, true_classes=given)
    assert policy.decided == given[:, :10].ravel().tolist()


def test_truth_draws_what_the_model_believes() -> None:
    model = seeing_model()
    truth = SortingModel(model.classes, model.viewpoints, model.p_obs[:, :, [1, 2, 0]])
    assert evaluate(model, LookThenDecide(), batches=3, truth=truth).correct.tolist() == [0, 0, 0]


@pytest.mark.parametrize("biased", [{"true_classes": [0, 1]}, {"truth": random_model(9)}])
def test_biased_expectations_are_refused(biased: dict[str, Any]) -> None:
    model = random_model(0)
    result = evaluate(model, Threshold(model, 0.7), batches=2, **biased)
    with pytest.raises(ArgumentError, match=r"expected_discounted_returns.*biased.*\bdiscounted_returns"):
        _ = result.expected_discounted_returns
    assert "expected_discounted_returns" not in result.summary()


def test_an_equal_truth_is_no_bias() -> None:
    model = random_model(0)
    result = evaluate(model, Threshold(model, 0.7), batches=2, truth=random_model(0))
    assert result.expected_discounted_returns.shape == (2,)


def test_summary(paper: SortingModel) -> None:
    result = evaluate(paper, Threshold(paper, 0.9), batches=40)
    for name, statistics in result.summary().items():
        sample = getattr(result, name)
        assert statistics["mean"] == pytest.approx(sample.mean())
        assert statistics["standard_error"] == pytest.approx(sample.std(ddof=1) / np.sqrt(40))
    assert len(result.summary()) == 6


def test_max_looks_ends_every_search() -> None:
    model = random_model(0, h=1)
    result = evaluate(model, Always(Move(0)), batches=3, batch_size=4, max_looks=5)
    assert result.steps.tolist() == [4 * (5 + 1)] * 3
    assert result.forced.tolist() == [4] * 3


def test_second_looks_repeat_as_often_as_the_truth_says() -> None:
    """A second label agrees with the first with probability repeat + (1 - repeat) / L."""
    model = random_model(0, h=1, k=1)
    blind = SortingModel(model.classes, model.viewpoints, np.full((1, 1, 3, 3), 1 / 3), repeat=0.4)
    policy = Recorded(LookThenDecide(looks=5))
    evaluate(blind, policy, batches=200)
    labels = np.array([belief.last_labels[0, 0] for belief, _ in policy.asked]).reshape(2000, 6)
    assert np.all(labels[:, 0] == -1)
    agreement, expected = np.mean(labels[:, 2:] == labels[:, 1:-1]), 0.4 + 0.6 / 3
    assert abs(agreement - expected) < 4 * np.sqrt(expected * (1 - expected) / 8000)
    assert np.bincount(labels[:, 5]) / 2000 == pytest.approx(1 / 3, abs=0.05)


@pytest.mark.parametrize("belt_ends", [True, False])
def test_beliefs_tell_where_the_belt_ends(belt_ends: bool) -> None:
    model = random_model(0)
    policy = Recorded(LookThenDecide())
    evaluate(model, policy, batches=1, batch_size=2, belt_ends=belt_ends)
    told = [belief.remaining for belief, _ in policy.asked]
    assert told == ([2, 2, 1, 1] if belt_ends else [None] * 4)


def test_a_scan_from_where_the_camera_stands_follows_a_decision() -> None:
    model = random_model(0, repeat=0.5, observe_after_decision=True)
    policy = Recorded(LookThenDecide(viewpoint=1))
    evaluate(model, policy, batches=1, batch_size=3)
    for before, after in zip(policy.asked[1::2], policy.asked[2::2], strict=False):
        expected, viewpoint = before[0].copy(), before[1]
        expected.advance()
        expected.observe(viewpoint, after[0].last_labels[:, viewpoint].tolist())
        assert after == (expected, viewpoint)


def test_a_scan_after_a_decision_is_a_look_but_no_step() -> None:
    model = seeing_model(h=2, observe_after_decision=True)
    result = evaluate(model, Threshold(model, 0.9), batches=2)
    assert result.steps.tolist() == [1 + 10] * 2
    assert result.correct.tolist() == [10] * 2
    result = evaluate(model, Always(Move(0)), batches=1, batch_size=3, max_looks=5)
    # The second object is seen as often as the first; the third only after both decisions.
    assert result.steps.tolist() == [(5 + 1) + (0 + 1) + (3 + 1)]


def test_bonuses_by_hand() -> None:
    plain = seeing_model(discount=0.5)
    paid = seeing_model(discount=0.5, information_gain=2.0)
    without, result = (evaluate(m, LookThenDecide(), batches=1, batch_size=2) for m in (plain, paid))
    assert result.returns.tolist() == without.returns.tolist()
    assert result.expected_discounted_returns.tolist() == without.expected_discounted_returns.tolist()
    assert result.bonuses.tolist() == pytest.approx([2 * 2 * np.log(3)])
    assert result.discounted_bonuses.tolist() == pytest.approx([2 * np.log(3) * (1 + 0.5**2)])
    assert without.bonuses.tolist() == [0.0]
    assert set(result.summary()) - set(without.summary()) == {"bonuses", "discounted_bonuses"}


def test_the_scan_after_a_decision_earns_its_bonus_within_the_step() -> None:
    model = seeing_model(discount=0.5, information_gain=2.0, observe_after_decision=True)
    result = evaluate(model, Threshold(model, 0.9), batches=1, batch_size=2)
    assert result.discounted_bonuses.tolist() == pytest.approx([2 * np.log(3) * (1 + 0.5 + 0.5**2)])


def test_a_bonus_is_the_expected_drop_of_entropy() -> None:
    model = random_model(3, h=1, repeat=0.5, information_gain=1.0)
    policy = Recorded(LookThenDecide(looks=4))
    result = evaluate(model, policy, batches=1, batch_size=1)
    drops = [expected_drop(belief, 0) for belief, _ in policy.asked[:4]]
    assert result.bonuses.tolist() == pytest.approx([sum(drops)])
    assert min(drops) > 0


def expected_drop(belief: Belief, viewpoint: int) -> float:
    """Entropy of a belief about one position, less its expectation after a scan, by enumeration."""
    left = 0.0
    for z, probability in enumerate(belief.label_probabilities(viewpoint)[0]):
        posterior = belief.copy()
        posterior.observe(viewpoint, [z])
        left += probability * entropy(posterior)
    return entropy(belief) - left


def entropy(belief: Belief) -> float:
    b = belief.probabilities
    return float(-np.sum(b * np.log(b)))
