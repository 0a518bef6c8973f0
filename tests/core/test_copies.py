"""Copies of models, beliefs, policies and results, by pickle and by `copy`."""

import copy
import pickle
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from typing import Any

import numpy as np
import pytest

from beltsort import (
    ArgumentError,
    Belief,
    Despot,
    Evaluation,
    InformationGain,
    LookAhead,
    OneObject,
    Plan,
    Solution,
    SortingModel,
    Threshold,
    compare,
    evaluate,
    solve,
)
from beltsort.models import simulated

from .models import beyond_model, random_model

NUMBERS = ("lower", "upper", "certified_lower", "certified_upper", "trials", "seconds", "scenario_steps")


def pickled(thing: Any) -> Any:
    return pickle.loads(pickle.dumps(thing))


def assert_equal_plans(plan: Plan, other: Plan, but: tuple[str, ...] = ()) -> None:
    assert (plan.action, plan.values) == (other.action, other.values)
    for number in set(NUMBERS) - set(but):
        assert getattr(plan, number) == getattr(other, number)


def beliefs() -> dict[str, Belief]:
    found = {
        "plain": Belief(random_model(0)),
        "remaining": Belief(random_model(1), remaining=3),
        "modes": Belief(beyond_model(2)),
        "many modes": Belief(simulated()),
        "repeat": Belief(random_model(3, repeat=[[0.5, 0.0], [0.3, 0.9]]), remaining=2),
    }
    for belief in found.values():
        belief.observe(0, [0, 1])
        belief.observe(1, [1, None])
    found["none left"] = Belief(random_model(0), remaining=0)
    return found


@pytest.mark.parametrize("copied", [pickled, copy.copy, copy.deepcopy])
@pytest.mark.parametrize("name", beliefs())
def test_beliefs(name: str, copied: Any) -> None:
    belief = beliefs()[name]
    again = copied(belief)
    assert again == belief
    assert np.array_equal(again.kinds, belief.kinds)  # to the last bit
    assert np.array_equal(again.last_labels, belief.last_labels)
    assert (again.remaining, again.model) == (belief.remaining, belief.model)
    again.observe(0, [1, 1])
    again.advance()
    assert again != belief  # they have nothing in common
    assert belief == beliefs()[name]


SOLVED = solve(random_model(4), seconds=0.2)
POLICIES: dict[str, Any] = {
    "despot": Despot(SOLVED.model, trials=20, scenarios=50, seed=3, depth=20),
    "despot with solution": Despot(SOLVED.model, trials=20, solution=SOLVED),
    "despot as published": Despot(
        SOLVED.model, trials=20, scenarios=50, threads=1, variant="scenarios", regularization=0.1
    ),
    "despot with modes": Despot(beyond_model(0), trials=10),
    "threshold": Threshold(SOLVED.model, 0.8, viewpoint="v1"),
    "threshold, best viewpoint": Threshold(SOLVED.model, 0.8),
    "information gain": InformationGain(SOLVED.model, 0.8, 2, about="bin"),
    "one object": OneObject(SOLVED.model),
    "look ahead": LookAhead(SOLVED.model, 2, scenarios=30, seed=5),
    "solution": SOLVED,
}


@pytest.mark.parametrize("name", POLICIES)
def test_policies(name: str) -> None:
    policy = POLICIES[name]
    again: Any = pickled(policy)
    assert again.model == policy.model
    assert repr(again) == repr(policy)
    results = [evaluate(policy.model, one, batches=10, seed=1) for one in (policy, again)]
    assert results[0].returns.tolist() == results[1].returns.tolist()
    assert copy.copy(policy) is policy is copy.deepcopy(policy)  # policies do not change


@pytest.mark.parametrize("name", [name for name in POLICIES if name.startswith("despot")])
def test_planners_give_the_same_plans(name: str) -> None:
    planner = POLICIES[name]
    assert isinstance(planner, Despot)
    again = pickled(planner)
    assert again.settings == planner.settings
    belief = Belief(planner.model)
    belief.observe(0, [0, 1])
    assert_equal_plans(planner.plan(belief), again.plan(belief), but=("seconds",))


def test_settings_are_keywords_of_the_constructor() -> None:
    for name in ("threshold", "threshold, best viewpoint", "information gain", "look ahead"):
        policy: Any = POLICIES[name]
        assert type(policy)(policy.model, **policy.settings).settings == policy.settings


def test_models(paper: SortingModel) -> None:
    for model in (paper, beyond_model(0), random_model(0, repeat=0.5, counts=None)):
        assert pickled(model) == model
        assert copy.deepcopy(model) is model is copy.copy(model)


def test_solutions() -> None:
    again: Solution = pickled(SOLVED)
    assert (again.lower, again.upper, again.seconds) == (SOLVED.lower, SOLVED.upper, SOLVED.seconds)
    belief = Belief(SOLVED.model)
    belief.observe(0, [0, 1])
    assert again.bounds(belief) == SOLVED.bounds(belief)


@pytest.mark.parametrize("name", [name for name in POLICIES if name.startswith("despot")])
def test_plans(name: str) -> None:
    planner = POLICIES[name]
    assert isinstance(planner, Despot)
    plan = planner.plan(Belief(planner.model))
    again = pickled(plan)
    assert_equal_plans(plan, again)
    assert again.model == plan.model
    assert repr(again) == repr(plan)
    assert copy.deepcopy(plan) is plan
    with pytest.raises(ArgumentError, match="nor does a plan that was pickled; plan anew"):
        again.tree()


def test_evaluations(paper: SortingModel) -> None:
    policy = Threshold(paper, 0.9)
    for result in (
        evaluate(paper, policy, batches=4),
        evaluate(paper, policy, batches=1, true_classes=["mushroom"]),
        evaluate(SOLVED.model, SOLVED, batches=3, reference=SOLVED),
    ):
        again: Evaluation = pickled(result)
        assert repr(again.summary()) == repr(result.summary())  # NaN is not equal to itself
        assert again.confusion.tolist() == result.confusion.tolist()


def test_comparisons(paper: SortingModel) -> None:
    compared = compare(paper, {"a": Threshold(paper, 0.9), "b": Threshold(paper, 0.8)}, batches=4)
    assert repr(pickled(compared)) == repr(copy.deepcopy(compared)) == repr(compared)


def returns(planner: Despot, seed: int) -> Evaluation:
    return evaluate(planner.model, planner, batches=3, seed=seed)


@pytest.mark.process
def test_planners_in_other_processes() -> None:
    planner = POLICIES["despot"]
    assert isinstance(planner, Despot)
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        elsewhere = list(pool.map(returns, [planner] * 2, range(2)))
    for seed, result in enumerate(elsewhere):
        assert result.returns.tolist() == returns(planner, seed).returns.tolist()
