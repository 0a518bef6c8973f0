"""Despot: reproducible, bounded, legal, and explained."""

from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from typing import Any, Literal, TypeAlias, get_args

import pytest
from hypothesis import given
from hypothesis import strategies as st

from beltsort import ArgumentError, Belief, Decide, Despot, Move, Plan, SortingModel, evaluate
from tests.interrupting import interrupted
from tests.laws import cases

from .models import random_belief, random_model
from .trees import nodes

SEEDS = st.integers(0, 10_000)
Variant: TypeAlias = Literal["beliefs", "scenarios"]
VARIANTS: tuple[Variant, ...] = get_args(Variant)


def facts(plan: Plan) -> tuple[object, ...]:
    counters = (plan.trials, plan.nodes, plan.expansions, plan.scenario_steps)
    certified = (plan.certified_lower, plan.certified_upper)
    tree = plan.tree(2) if plan.certified_lower is not None else None
    return plan.action, plan.values, plan.lower, plan.upper, certified, *counters, tree


@pytest.mark.slow
@pytest.mark.parametrize("variant", VARIANTS)
def test_trials_are_reproducible_for_any_number_of_threads(paper: SortingModel, variant: Variant) -> None:
    belief = random_belief(paper, 1)
    plans = []
    for threads in (1, 2, 4, 8):
        planner = Despot(paper, scenarios=2000, seed=3, trials=700, threads=threads, variant=variant)
        plans += [planner.plan(belief, 1), planner.plan(belief, 1)]
    assert all(facts(plan) == facts(plans[0]) for plan in plans)
    other = Despot(paper, scenarios=2000, seed=4, trials=700, variant=variant)
    assert facts(other.plan(belief, 1)) != facts(plans[0])


@pytest.mark.parametrize("variant", VARIANTS)
def test_settings_make_the_same_planner_again(paper: SortingModel, variant: Variant) -> None:
    planner = Despot(paper, scenarios=50, seed=5, trials=30, depth=20, variant=variant)
    again = Despot(paper, **planner.settings)
    assert again.settings == planner.settings
    assert facts(again.plan(Belief(paper))) == facts(planner.plan(Belief(paper)))


def test_the_published_variant_is_regularised_and_keeps_no_tree(paper: SortingModel) -> None:
    def plan(regularization: float) -> Plan:
        planner = Despot(paper, regularization=regularization, trials=300, variant="scenarios")
        return planner.plan(Belief(paper))

    free, dear = plan(0.0), plan(1e3)
    assert dear.lower < free.lower
    assert dear.certified_lower is None
    assert max(dear.values.values()) < dear.lower, "no node is worth its price"
    with pytest.raises(ArgumentError, match="variant"):
        dear.tree()


@pytest.mark.slow
@cases(8)
@given(seed=SEEDS, variant=st.sampled_from(VARIANTS))
def test_bounds_tighten_with_trials(seed: int, variant: Variant) -> None:
    model = random_model(seed)
    regularization = 0.1 if variant == "scenarios" else None
    planner = Despot(model, scenarios=100, regularization=regularization, trials=1, variant=variant)
    belief = random_belief(model, seed)
    plans = [planner.plan(belief, trials=n) for n in (1, 2, 4, 8, 16, 32, 64)]
    for before, after in pairwise(plans):
        assert before.lower <= after.lower <= after.upper <= before.upper
    assert plans[-1].upper < plans[0].upper
    for plan in plans:
        assert plan.certified_upper is not None
        assert (plan.certified_lower is None) == (variant == "scenarios")
        assert plan.certified_lower is None or plan.certified_lower <= plan.certified_upper


@pytest.mark.slow
def test_searching_on_where_scenarios_have_run_out_does_no_harm(paper: SortingModel) -> None:
    planner = Despot(paper, scenarios=3, trials=200)
    at_root = planner.plan(Belief(paper))
    assert max(at_root.values.values()) > at_root.upper, "no estimate is cut by the sampled problem's bound"
    few, many = (
        evaluate(paper, Despot(paper, scenarios=3, trials=trials), batches=20, seed=8).summary()
        for trials in (20, 200)
    )
    gain = many["expected_discounted_returns"]["mean"] - few["expected_discounted_returns"]["mean"]
    assert gain > -1, "more trials once were worth -6"


TRAVEL = st.lists(st.sets(st.integers(0, 2)).map(sorted), min_size=3, max_size=3)


@cases(25)
@given(travel=TRAVEL, seed=SEEDS, h=st.integers(1, 2))
def test_only_legal_actions(travel: list[list[int]], seed: int, h: int) -> None:
    model = random_model(seed, h=h, k=3, travel=travel, r_min=10)
    planner = Despot(model, scenarios=50, trials=40)
    for viewpoint in range(3):
        plan = planner.plan(random_belief(model, seed), viewpoint)
        decisions = {Decide(label) for label in range(3)}
        assert set(plan.values) == decisions | {Move(to) for to in travel[viewpoint]}
        assert plan.action in plan.values
        assert plan.values[plan.action] == pytest.approx(max(plan.values.values()), abs=1e-9)
        for node in nodes(plan.tree(4)):
            moves = [action["action"]["move"] for action in node["actions"] if "move" in action["action"]]
            assert moves == (travel[node["viewpoint"]] if node["actions"] else [])


def test_nowhere_to_go() -> None:
    model = random_model(0, travel=[[], []])
    plan = Despot(model, trials=10).plan(random_belief(model, 0))
    assert isinstance(plan.action, Decide)
    assert set(plan.values) == {Decide(0), Decide(1), Decide(2)}


def test_decisions_differ_by_their_expected_reward(paper: SortingModel) -> None:
    belief = random_belief(paper, 5)
    values = Despot(paper, trials=20).plan(belief).values
    likely, unlikely = belief.probabilities[0, :2]
    reward_per_probability = paper.r_max + paper.r_min
    assert values[Decide(0)] - values[Decide(1)] == pytest.approx(
        (likely - unlikely) * reward_per_probability
    )


@pytest.mark.slow
def test_budgets(paper: SortingModel) -> None:
    belief = Belief(paper)
    assert Despot(paper, trials=7).plan(belief).trials == 7
    assert Despot(paper, trials=7).plan(belief, trials=3).trials == 3
    planner = Despot(paper, trials=7)
    # How many trials there is time for, is the machine's affair.
    assert any(planner.plan(belief, seconds=seconds).trials > 7 for seconds in (0.05, 0.5, 5.0, 50.0))
    settings = Despot(paper).settings
    assert (settings["seconds"], settings["trials"]) == (0.01, None)


def test_a_planner_is_a_policy(paper: SortingModel) -> None:
    planner = Despot(paper, trials=20)
    assert planner.act(Belief(paper), 0) == planner.plan(Belief(paper), 0).action == Move(2)
    assert planner.model == paper


def test_a_belief_of_an_equal_model_is_welcome(paper: SortingModel) -> None:
    again = SortingModel.from_json(paper.to_json())
    assert Despot(paper, trials=1).plan(Belief(again)).trials == 1


def test_planning_releases_the_gil(paper: SortingModel) -> None:
    with interrupted():  # by a thread that takes turns while the plan is made
        Despot(paper).plan(Belief(paper), seconds=20.0)


@pytest.mark.slow
def test_plans_from_many_threads_at_once(paper: SortingModel) -> None:
    planner = Despot(paper, trials=100)
    beliefs = [random_belief(paper, seed % 8) for seed in range(32)]
    alone = [facts(planner.plan(belief)) for belief in beliefs[:8]]
    with ThreadPoolExecutor(4) as pool:
        together = [facts(plan) for plan in pool.map(planner.plan, beliefs)]
    assert together == alone * 4


@pytest.mark.slow
@pytest.mark.parametrize("budget", [{"seconds": 100_000.0}, {"trials": 10**9}])
@pytest.mark.parametrize("threads", [1, 4])
def test_control_c_ends_a_plan_and_nothing_else(
    paper: SortingModel, budget: dict[str, Any], threads: int
) -> None:
    planner = Despot(paper, trials=1500, threads=threads)
    before = facts(planner.plan(Belief(paper)))
    with interrupted():
        planner.plan(Belief(paper), **budget)
    assert facts(planner.plan(Belief(paper))) == before
