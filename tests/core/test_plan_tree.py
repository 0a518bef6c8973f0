"""Plan.tree: the searched tree, true to the model and ready for JSON."""

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from beltsort import Belief, Decide, Despot, Move, SortingModel
from beltsort.planning.plan_tree import TreeNode
from tests.laws import cases

from .models import random_belief, random_model
from .trees import nodes

MODELS = st.builds(
    random_model,
    st.integers(0, 10_000),
    r_min=st.just(10.0),
    repeat=st.sampled_from([None, 0.5]),
    observe_after_decision=st.booleans(),
    information_gain=st.sampled_from([0.0, 0.5]),
)


def follow(belief: Belief, viewpoint: int, action: dict[str, int], labels: list[int] | None) -> Belief:
    """What is believed after an action and its labels, by the belief's own arithmetic."""
    after = belief.copy()
    if "decide" in action:
        after.advance()
    if labels is not None:
        after.observe(action.get("move", viewpoint), list(labels))
    return after


def check(node: TreeNode, belief: Belief) -> None:
    np.testing.assert_allclose(node["belief"], belief.probabilities, atol=1e-12)
    assert node["lower"] <= min(node["value"], node["upper"])
    if not node["actions"]:
        return
    assert node["scenarios"] is not None
    assert node["upper"] == pytest.approx(max(action["upper"] for action in node["actions"]))
    for action in node["actions"]:
        probabilities = [branch["probability"] for branch in action["branches"]]
        assert probabilities == sorted(probabilities, reverse=True)
        assert sum(probabilities) < 1 + 1e-9
        for branch in action["branches"]:
            after = follow(belief, node["viewpoint"], action["action"], branch["labels"])
            check(branch["node"], after)


@pytest.mark.slow
@cases(20)
@given(model=MODELS, seed=st.integers(0, 10_000))
def test_every_belief_is_that_of_its_labels(model: SortingModel, seed: int) -> None:
    belief = random_belief(model, seed)
    check(Despot(model, scenarios=100, trials=60).plan(belief, 1).tree(3), belief)


@cases(10)
@given(model=MODELS, seed=st.integers(0, 10_000))
def test_the_root_is_the_plan(model: SortingModel, seed: int) -> None:
    plan = Despot(model, scenarios=100, trials=60).plan(random_belief(model, seed), 1)
    tree = plan.tree(1)
    assert (tree["viewpoint"], tree["scenarios"]) == (1, 100)
    assert (tree["lower"], tree["upper"]) == (plan.lower, plan.upper)
    moves = {Move(a["action"]["move"]): a["value"] for a in tree["actions"] if "move" in a["action"]}
    assert moves == {action: value for action, value in plan.values.items() if isinstance(action, Move)}
    (decision,) = (a for a in tree["actions"] if "decide" in a["action"])
    best = max(value for action, value in plan.values.items() if isinstance(action, Decide))
    assert decision["value"] == pytest.approx(best)
    assert plan.values[Decide(decision["action"]["decide"])] == pytest.approx(best)


def test_a_tree_is_json(paper: SortingModel) -> None:
    tree = Despot(paper, trials=100).plan(Belief(paper)).tree(3)
    assert json.loads(json.dumps(tree, allow_nan=False)) == tree


def test_depth(paper: SortingModel) -> None:
    plan = Despot(paper, trials=100).plan(Belief(paper))
    assert plan.tree() == plan.tree(2)
    assert plan.tree(0)["actions"] == []
    sizes = [len(list(nodes(plan.tree(depth)))) for depth in (0, 1, 2, 1000)]
    assert sizes[0] == 1
    assert sizes == sorted(set(sizes))
    assert sizes[-1] == plan.nodes


@pytest.mark.slow
def test_a_tree_outlives_its_planner(paper: SortingModel) -> None:
    planner = Despot(paper, trials=100)
    plan = planner.plan(Belief(paper))
    tree = plan.tree(3)
    planner.plan(random_belief(paper, 1))
    del planner
    assert plan.tree(3) == tree
