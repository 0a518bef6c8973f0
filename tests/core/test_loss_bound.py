"""How much a policy loses at most: a certified bound of the optimal value minus what is earned."""

import json
import math
from typing import Any

import numpy as np
import pytest

from beltsort import (
    ArgumentError,
    Comparison,
    Decide,
    Despot,
    InformationGain,
    Move,
    OneObject,
    Policy,
    Solution,
    SortingModel,
    Threshold,
    compare,
    evaluate,
    solve,
)
from beltsort.planning.loss_bound import CONFIDENCE, LossBound, loss_bound

from .models import random_model, seeing_model
from .policies import LookThenDecide
from .solving import solved_until, within

LONG = 60  # decisions, at least a step each: discount^steps is below 0.05


def policies(model: SortingModel) -> dict[str, Policy]:
    return {
        "one": OneObject(model),
        "careful": Threshold(model, 0.97),
        "curious": InformationGain(model, 0.8, model.positions),
        "unseen": LookThenDecide(looks=0),
    }


@pytest.fixture(scope="module")
def wide() -> Solution:
    return solved_until(within(1.0), random_model(3, h=3, k=2, n=2, r_min=20), seconds=0.5)


@pytest.fixture(scope="module")
def of_wide(wide: Solution) -> Comparison:
    return compare(wide.model, policies(wide.model), batches=60, batch_size=LONG, seed=5, reference=wide)


@pytest.mark.parametrize("batch_size", [1, 10, LONG])
@pytest.mark.parametrize("seed", [0, 1])
def test_the_bound_is_no_less_than_the_regret(seed: int, batch_size: int) -> None:
    model = random_model(seed, h=2, k=2, n=2, r_min=20)
    solution = solve(model, seconds=0.5)
    compared = compare(model, policies(model), batches=200, batch_size=batch_size, seed=7, reference=solution)
    for name, bound in compared.loss_bounds.items():
        regrets = compared.outcomes(name, "discounted_regrets")
        error = math.hypot(bound.standard_error, regrets.std(ddof=1) / math.sqrt(len(regrets)))
        assert bound.mean >= regrets.mean() - 2 * error, name


def test_the_bound_is_no_less_than_the_loss_where_both_values_are_known() -> None:
    model = seeing_model(n=2, r_min=20.0, discount=0.9)
    optimum = (10 * model.discount - 1) / (1 - model.discount**2)  # look, decide, look, ...
    blind = (10 - 20) / 2 / (1 - model.discount)  # decide unseen: right half of the time
    solution = solve(model, seconds=1)
    assert solution.upper == pytest.approx(optimum, abs=1e-3)
    for size in (1, 5, 200):
        unseen = loss_bound(evaluate(model, LookThenDecide(looks=0), batches=20, batch_size=size), solution)
        assert unseen.mean >= optimum - blind - 1e-9
        seen = loss_bound(evaluate(model, LookThenDecide(looks=1), batches=20, batch_size=size), solution)
        assert seen.mean >= 0.0
    assert unseen.mean == pytest.approx(optimum - blind, abs=1e-3), (
        "long batches: nothing is left of the tail"
    )
    assert seen.mean == pytest.approx(0.0, abs=1e-3)


def test_even_the_worst_policy_loses_no_more_than_short_batches_say() -> None:
    class AlwaysWrong:
        """Look, then decide what was not seen: nothing that comes after a batch is better."""

        def __init__(self) -> None:
            self.looked = False

        def act(self, belief: Any, viewpoint: int) -> Move | Decide:
            self.looked = not self.looked
            return Move(0) if self.looked else Decide(1 - belief.most_likely(0)[0])

    model = seeing_model(n=2, r_min=20.0, discount=0.9)
    value = -(1 + 20 * model.discount) / (1 - model.discount**2)
    solution = solve(model, seconds=1)
    for size in (1, 3, 10):
        bound = loss_bound(evaluate(model, AlwaysWrong(), batches=2, batch_size=size), solution)
        assert bound.mean >= solution.lower - value


def test_longer_batches_tighten_it(wide: Solution) -> None:
    short, long = (
        loss_bound(evaluate(wide.model, OneObject(wide.model), batches=100, batch_size=size), wide)
        for size in (5, LONG)
    )
    assert short.mean > long.mean
    assert short.tail > long.tail
    steps = evaluate(wide.model, OneObject(wide.model), batches=100, batch_size=5).steps
    per_step = max(wide.model.r_min, 1.0) / (1 - wide.model.discount)
    assert short.tail == pytest.approx(np.mean(wide.model.discount ** steps.astype(float)) * per_step)


def test_three_positions(wide: Solution, of_wide: Comparison) -> None:
    assert not wide.values_actions
    assert "regrets" not in of_wide.metrics
    assert list(of_wide.loss_bounds) == list(policies(wide.model))
    for name, bound in of_wide.loss_bounds.items():
        returns = of_wide.outcomes(name, "expected_discounted_returns")
        assert bound.optimal_value == wide.upper
        assert bound.expected_return == returns.mean()
        assert bound.mean == pytest.approx(wide.upper - returns.mean() + bound.tail)
        assert bound.mean > -2 * bound.standard_error
    one, unseen = (of_wide.loss_bounds[name] for name in ("one", "unseen"))
    assert one.mean < unseen.mean


def test_a_good_planner_loses_next_to_nothing_where_the_bounds_are_tight(wide: Solution) -> None:
    assert wide.upper - wide.lower < 1.0
    planner = Despot(wide.model, trials=20, scenarios=100)
    bound = loss_bound(evaluate(wide.model, planner, batches=60, batch_size=LONG, seed=5), wide)
    assert bound.mean - bound.tail < 1.0 + 3 * bound.standard_error


def test_the_viewpoint_that_batches_start_from_counts() -> None:
    model = random_model(4, h=1, k=2, n=2, motion_cost=[[1.0, 9.0], [5.0, 2.0]])
    solution = solve(model, seconds=0.3)
    result = evaluate(model, OneObject(model), batches=5, viewpoint=1)
    from_there = loss_bound(result, solution, 1).optimal_value
    assert from_there != loss_bound(result, solution, 0).optimal_value


def test_confidence_limit() -> None:
    bound = LossBound(optimal_value=5.0, expected_return=3.0, tail=0.5, mean=2.5, standard_error=0.2)
    assert CONFIDENCE == 0.95
    assert bound.confidence_limit == pytest.approx(2.5 + 1.645 * 0.2, abs=1e-3)


def test_in_words_and_as_plain_data(of_wide: Comparison) -> None:
    text = str(of_wide)
    bound = of_wide.loss_bounds["careful"]
    assert "optimal value at most (certified)" in text
    assert f"{bound.mean:.3f} ± {bound.standard_error:.3f}" in text
    assert "upper 95 % confidence limit" in text
    data = json.loads(json.dumps(of_wide.to_dict(), allow_nan=False))
    assert data["loss_bounds"]["careful"] == {
        "optimal_value": bound.optimal_value,
        "expected_return": bound.expected_return,
        "tail": bound.tail,
        "mean": bound.mean,
        "standard_error": bound.standard_error,
        "confidence_limit": bound.confidence_limit,
    }


def test_a_single_batch_has_no_confidence_limit(wide: Solution) -> None:
    compared = compare(wide.model, policies(wide.model), batches=1, reference=wide)
    data = compared.to_dict()["loss_bounds"]["one"]
    assert data["standard_error"] is None
    assert data["confidence_limit"] is None


def test_without_a_reference_there_are_none(wide: Solution) -> None:
    compared = compare(wide.model, policies(wide.model), batches=2)
    assert compared.to_dict()["loss_bounds"] == {}
    assert "Loss against" not in str(compared)


def test_a_reference_that_says_nothing_is_refused(wide: Solution) -> None:
    model, chosen = wide.model, policies(wide.model)
    with pytest.raises(ArgumentError, match=r"r_min.*\b20\b.*\b5\b"):
        compare(model.replace(r_min=5), chosen, batches=2, reference=wide)
    with pytest.raises(ArgumentError, match="belt_ends"):
        compare(model, chosen, batches=2, reference=wide, belt_ends=True)
    with pytest.raises(ArgumentError, match="leave out true_classes"):
        compare(model, chosen, batches=2, reference=wide, true_classes=[0, 1])
    with pytest.raises(ArgumentError, match="leave out true_classes"):
        compare(model, chosen, batches=2, reference=wide, truth=random_model(9, h=3, k=2, n=2))
    noted = model.replace(note="the same but for this remark")
    assert compare(noted, policies(noted), batches=2, reference=wide).loss_bounds


def test_given_objects_have_regrets_only() -> None:
    model = random_model(0, h=1, k=1, n=2)
    solution = solve(model, seconds=0.2)
    compared = compare(model, policies(model), batches=2, reference=solution, true_classes=[0])
    assert "regrets" in compared.metrics
    assert compared.loss_bounds == {}
