"""evaluate_moving: runs of a moving belt, and their statistics."""

import pickle

import numpy as np
import pytest

import beltsort
from beltsort import (
    ArgumentError,
    DecideAt,
    Move,
    MovingBelief,
    MovingBelt,
    MovingPlanner,
    MovingThreshold,
    PolicyError,
    Wait,
    evaluate_moving,
)


@pytest.fixture(scope="module")
def belt() -> MovingBelt:
    return MovingBelt(beltsort.models.paper(), ticks_per_place=4, reach=2, seconds_per_tick=0.5)


class Mirror:
    """Asks another policy."""

    def __init__(self, policy: MovingThreshold) -> None:
        self.policy = policy

    def act(self, belief: MovingBelief, viewpoint: int) -> Move | Wait | DecideAt:
        """Return what the other one does."""
        return self.policy.act(belief, viewpoint)


class Idle:
    """Waits."""

    def act(self, belief: MovingBelief, viewpoint: int) -> Wait:
        """Return a wait."""
        return Wait()


def test_a_policy_in_python_is_simulated_like_the_same_one_in_rust(belt: MovingBelt) -> None:
    policy = MovingThreshold(belt, 0.9, 0.6, "information-per-tick")
    ours, mirrored = (evaluate_moving(belt, p, objects=6, runs=5, seed=2) for p in (policy, Mirror(policy)))
    assert pickle.dumps(ours) == pickle.dumps(mirrored)
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(ours)).returns, mirrored.returns)


def test_every_object_is_right_wrong_or_missed_and_statistics_say_so(belt: MovingBelt) -> None:
    result = evaluate_moving(belt, MovingPlanner(belt, trials=1), objects=10, runs=20)
    np.testing.assert_array_equal(result.right + result.wrong + result.missed.sum(axis=1), 10)
    np.testing.assert_array_equal(result.confusion.sum(axis=(1, 2)), result.right + result.wrong)
    found = result.statistics()
    assert found.right.value + found.wrong.value + found.missed.value == pytest.approx(1)
    assert found.reward_per_object.value == pytest.approx(result.returns.mean() / 10)
    assert found.reward_per_object.standard_error > 0
    assert found.objects_per_minute is not None
    decided = result.right.sum() + result.wrong.sum()
    assert found.objects_per_minute.value == pytest.approx(decided / (result.ticks.sum() * 0.5 / 60))
    assert found.least_purity.value == min(each.purity.value for each in found.bins)
    assert str(found.right) in repr(result)
    assert found.to_dict()["missed"]["value"] == found.missed.value


def test_a_policy_that_only_waits_misses_everything(belt: MovingBelt) -> None:
    found = evaluate_moving(belt, Idle(), objects=7, runs=2).statistics()
    assert (found.missed.value, found.looks_per_object.value) == (1, 0)
    assert found.reward_per_object.value == -belt.missed[0]
    assert found.ticks.value == 28
    assert np.isnan(found.least_purity.value)
    belt_without_clock = MovingBelt(belt.model, ticks_per_place=4)
    assert (
        evaluate_moving(belt_without_clock, Idle(), objects=7, runs=2).statistics().objects_per_minute is None
    )


def test_a_belt_that_advances_on_decisions_earns_what_the_model_alone_does() -> None:
    model = beltsort.models.paper()
    belt = MovingBelt(model, advance_ticks=1)
    moving = evaluate_moving(belt, MovingThreshold(belt, 0.9), objects=10, runs=50, seed=3)

    class Same:
        def act(self, belief: beltsort.Belief, viewpoint: int) -> Move | beltsort.Decide:
            known = MovingBelief(belt, kinds=belief.kinds)
            action = MovingThreshold(belt, 0.9).act(known, viewpoint)
            assert not isinstance(action, Wait)
            return beltsort.Decide(action.label) if isinstance(action, DecideAt) else action

    today = beltsort.evaluate(model, Same(), batches=50, batch_size=10, seed=3)
    np.testing.assert_allclose(moving.discounted_returns, today.discounted_returns, atol=1e-9)
    np.testing.assert_array_equal(moving.ticks, today.steps)


def test_a_policy_that_never_decides_ends() -> None:
    belt = MovingBelt(beltsort.models.paper(), advance_ticks=1)
    with pytest.raises(PolicyError, match="decided nothing for 10000 ticks"):
        evaluate_moving(belt, Idle(), objects=1, runs=1)


def test_what_is_no_policy_is_refused(belt: MovingBelt) -> None:
    class Mistaken:
        def act(self, belief: MovingBelief, viewpoint: int) -> str:
            return "wait"

    class Angry:
        def act(self, belief: MovingBelief, viewpoint: int) -> Wait:
            raise RuntimeError("no")

    with pytest.raises(PolicyError, match="has no method act; give MovingPlanner"):
        evaluate_moving(belt, 3)  # type: ignore[arg-type]  # the mistake
    with pytest.raises(PolicyError, match=r"returned 'wait'; return beltsort\.Move"):
        evaluate_moving(belt, Mistaken())  # type: ignore[arg-type]  # the mistake
    with pytest.raises(RuntimeError, match="no"):
        evaluate_moving(belt, Angry(), runs=1)
    with pytest.raises(ArgumentError, match="runs = 0"):
        evaluate_moving(belt, MovingThreshold(belt, 0.9), runs=0)
    for high, low in ((0.5, 0.9), (1.2, None)):
        with pytest.raises(ArgumentError, match="thresholds"):
            MovingThreshold(belt, high, low)
    with pytest.raises(ArgumentError, match='rule = "most"'):
        MovingThreshold(belt, 0.9, rule="most")
