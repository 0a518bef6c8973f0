"""What a model can say beyond tables and rewards: planning with it pays where it should.

Each time a planner that was told meets one that was not, on the same objects. Rewards are expected under the
true model's exact belief, so that small samples suffice; margins are several standard errors.
"""

from typing import Any

import numpy as np
import pytest

from beltsort import Belief, Decide, Despot, Move, Policy, SortingModel, compare, evaluate
from beltsort.planning.comparison import Comparison
from beltsort.planning.difference import Difference

from .models import named
from .policies import Recorded

BUDGET: dict[str, Any] = {"trials": 64, "scenarios": 200}


def model(accuracies: list[list[float]], classes: int = 2, **settings: Any) -> SortingModel:
    """A model whose labels are right with a probability per position and viewpoint, and else any other."""
    right = np.array(accuracies)[..., None, None]
    p_obs = np.where(np.eye(classes) > 0, right, (1 - right) / (classes - 1))
    return SortingModel(named("c", classes), named("v", right.shape[1]), p_obs, **settings)


class Ignorant:
    """Plans with a model of its own, and takes the legal action that it values most.

    It believes what follows from the labels under its own prior.
    """

    def __init__(self, model: SortingModel) -> None:
        self.planner = Despot(model, **BUDGET)

    def act(self, belief: Belief, viewpoint: int) -> Move | Decide:
        own = self.planner.model
        rows = belief.probabilities / belief.model.arrival * own.arrival
        values = self.planner.plan(Belief(own, rows / rows.sum(axis=1, keepdims=True)), viewpoint).values
        legal = belief.model.travel[viewpoint]
        allowed = [action for action in values if isinstance(action, Decide) or action.viewpoint in legal]
        return max(allowed, key=values.__getitem__)


def compared(truth: SortingModel, believed: SortingModel) -> Comparison:
    """A planner that was told the truth against one that believes something else."""
    policies: dict[str, Policy] = {"ignorant": Ignorant(believed), "told": Despot(truth, **BUDGET)}
    return compare(truth, policies, batches=100, seed=1)


def gain(truth: SortingModel, believed: SortingModel) -> Difference:
    return compared(truth, believed).difference("told", "expected_discounted_returns")


@pytest.mark.slow
def test_the_arrival_prior() -> None:
    tables = [[0.75, 0.7], [0.7, 0.65]]
    assert gain(model(tables, 3, arrival=[0.8, 0.1, 0.1]), model(tables, 3)).z > 5


def test_costs_of_motion() -> None:
    """The best viewpoint is dear to go to, and to look from again."""
    tables = [[0.8, 0.75], [0.75, 0.7]]
    assert gain(model(tables, motion_cost=[[5.0, 1.0], [5.0, 1.0]]), model(tables)).z > 5


@pytest.mark.slow
def test_restricted_travel() -> None:
    """The best viewpoint is a trap: it is left by way of a blind one only."""
    tables = [[0.75, 0.8, 0.5]]
    assert gain(model(tables, travel=[[0, 1], [2], [0]]), model(tables)).z > 5


def test_a_scan_after_each_decision() -> None:
    """A viewpoint that is dear to go to pays where each decision brings a free scan from it."""
    tables, cost = [[0.8, 0.95]], [[1.0, 6.0], [1.0, 6.0]]
    truth = model(tables, motion_cost=cost, observe_after_decision=True)
    assert gain(truth, model(tables, motion_cost=cost)).z > 5


@pytest.mark.slow
def test_repeated_labels() -> None:
    tables = [[0.85, 0.8]]
    assert gain(model(tables, repeat=0.6), model(tables)).z > 5


def test_a_bonus_for_information() -> None:
    """Looks that do not pay by the reward of the decision are taken for the bonus."""
    settings: dict[str, Any] = {"r_min": 5, "motion_cost": 5.5}
    told = compared(model([[0.8]], information_gain=20.0, **settings), model([[0.8]], **settings))
    assert told.difference("told", "bonuses").mean > 20
    assert told.difference("told", "expected_discounted_returns").mean < -10


def overconfidence(believed: SortingModel, truth: SortingModel) -> Difference:
    """How much more often a planner believes itself right, when it decides, than it is."""
    policy = Recorded(Despot(believed, **BUDGET))
    right = evaluate(believed, policy, batches=100, truth=truth).correct.sum() / 1000
    asked = zip(policy.asked, policy.answered, strict=True)
    believes = [belief.most_likely(0)[1] for (belief, _), action in asked if isinstance(action, Decide)]
    return Difference(float(np.mean(believes) - right), float(np.sqrt(right * (1 - right) / 1000)))


@pytest.mark.slow
def test_repeated_labels_do_not_make_overconfident() -> None:
    tables = [[0.85, 0.8]]
    truth = model(tables, repeat=0.6)
    assert abs(overconfidence(truth, truth).z) < 3
    assert overconfidence(model(tables), truth).z > 5


def test_an_empty_cup_is_a_class_like_another() -> None:
    plain, named_empty = (model([[0.8, 0.7], [0.7, 0.6]], 3, empty=empty) for empty in (None, "c2"))
    policies = [Despot(m, **BUDGET) for m in (plain, named_empty)]
    for row in ([0.3, 0.3, 0.4], [0.01, 0.02, 0.97]):
        plans = [p.plan(Belief(p.model, [row, row]), 1) for p in policies]
        assert plans[0].values == plans[1].values
        assert plans[0].tree(3) == plans[1].tree(3)
    assert plans[1].action == Decide(2)
    results = [evaluate(p.model, p, batches=10) for p in policies]
    assert results[0].returns.tolist() == results[1].returns.tolist()


@pytest.mark.slow
def test_the_end_of_the_belt(paper: SortingModel) -> None:
    truth = paper.replace(r_min=5)
    planner = Despot(truth, **BUDGET)
    endless, ending = (
        evaluate(truth, planner, batches=100, seed=1, belt_ends=belt_ends).expected_discounted_returns
        for belt_ends in (False, True)
    )
    gain = ending - endless
    assert gain.mean() > 5 * gain.std(ddof=1) / np.sqrt(gain.size)
