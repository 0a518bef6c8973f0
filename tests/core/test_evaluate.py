"""evaluate: fair, reproducible, and honest about what it cannot say."""

from typing import Any

import numpy as np
import pytest

from beltsort import (
    ArgumentError,
    Despot,
    Evaluation,
    InformationGain,
    Move,
    SortingModel,
    Threshold,
    evaluate,
)

from .models import random_model, seeing_model
from .policies import Always, LookThenDecide


def columns(result: Evaluation) -> list[list[float]]:
    arrays = (result.steps, result.correct, result.forced, result.returns, result.discounted_returns)
    return [array.tolist() for array in arrays]


def test_independent_of_threads_and_repetition(paper: SortingModel) -> None:
    for policy in (Threshold(paper, 0.9), Despot(paper, trials=3, scenarios=50)):
        once = columns(evaluate(paper, policy, batches=20, seed=5, threads=1))
        for threads in (1, 2, 8, None):
            assert columns(evaluate(paper, policy, batches=20, seed=5, threads=threads)) == once
        assert columns(evaluate(paper, policy, batches=20, seed=6)) != once


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
    with pytest.raises(ArgumentError, match=r"biased.*Use discounted_returns"):
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
