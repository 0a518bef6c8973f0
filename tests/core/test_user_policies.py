"""Policies that are Python objects: asked one question at a time, and never misquoted."""

import numpy as np
import pytest

from beltsort import Belief, Decide, Despot, Move, Policy, PolicyError, SortingModel, Threshold, evaluate
from tests.interrupting import interrupted

from .models import random_model
from .policies import Always


def test_a_users_exception_passes_through_unchanged(paper: SortingModel) -> None:
    class Broken:
        error = RuntimeError("camera on fire")

        def act(self, belief: Belief, viewpoint: int) -> Move:
            raise self.error

    with pytest.raises(RuntimeError) as raised:
        evaluate(paper, Broken(), batches=3)
    assert raised.value is Broken.error


@pytest.mark.parametrize(
    ("action", "message"),
    [(Move(1), r"Move\(1\).*viewpoint 0.*\[0\]"), (Decide(3), r"Decide\(3\).*viewpoint 0.*\b3\b")],
)
def test_an_illegal_action_is_refused(action: Move | Decide, message: str) -> None:
    model = random_model(0, travel=[[0], [0]])
    with pytest.raises(PolicyError, match=message):
        evaluate(model, Always(action), batches=1)


class Planning:
    """Plans with threads of its own, and notices if it is asked while it is still thinking."""

    def __init__(self, model: SortingModel) -> None:
        self.planner = Despot(model, trials=300, scenarios=2000, threads=2)
        self.thinking = False

    def act(self, belief: Belief, viewpoint: int) -> Move | Decide:
        assert not self.thinking
        self.thinking = True
        action = self.planner.act(belief, viewpoint)
        self.thinking = False
        return action


@pytest.mark.slow
def test_a_users_policy_is_asked_one_question_at_a_time(paper: SortingModel) -> None:
    assert evaluate(paper, Planning(paper), batches=8).steps.shape == (8,)


def wait_for_ever(model: SortingModel, policy: Policy) -> None:
    evaluate(model, policy, batches=10_000, max_looks=10**9)


@pytest.mark.parametrize("native", [True, False])
def test_control_c_ends_it(native: bool) -> None:
    model = random_model(0)
    never_sure = SortingModel(model.classes, model.viewpoints, np.full((2, 2, 3, 3), 1 / 3))
    policy = Threshold(never_sure, 0.9) if native else Always(Move(0))
    with interrupted():
        wait_for_ever(never_sure, policy)
