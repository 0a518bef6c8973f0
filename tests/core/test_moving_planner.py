"""MovingPlanner: plans for a belt of constant speed."""

import pickle

import pytest

import beltsort
from beltsort import ArgumentError, DecideAt, MovingBelief, MovingBelt, MovingPlanner


@pytest.fixture(scope="module")
def planner() -> MovingPlanner:
    belt = MovingBelt(beltsort.models.paper(), ticks_per_place=4, reach=2)
    return MovingPlanner(belt, trials=20)


def test_a_plan_is_a_function_of_its_arguments_also_of_a_pickled_planner(planner: MovingPlanner) -> None:
    belief = MovingBelief(planner.belt, offset=2, to_come=3)
    plans = [p.plan(belief) for p in (planner, pickle.loads(pickle.dumps(planner)))]
    assert plans[0].values == plans[1].values
    assert plans[0].lower <= plans[0].upper
    assert plans[0].action == planner.act(belief, 0)


def test_what_is_certain_is_decided_unless_it_is_decided_already(planner: MovingPlanner) -> None:
    kinds = [[0.25] * 4, [0.0, 0.0, 1.0, 0.0]]
    assert planner.plan(MovingBelief(planner.belt, kinds=kinds)).action == DecideAt(1, 2)
    decided = MovingBelief(planner.belt, kinds=kinds, decided=[False, True])
    assert planner.plan(decided).action != DecideAt(1, 2)


def test_a_threshold_falls_at_the_exit_and_shares_sum_to_one(planner: MovingPlanner) -> None:
    thresholds = planner.thresholds(0)
    assert len(thresholds) == 8
    assert thresholds[0] is not None
    assert thresholds[2] is not None
    assert thresholds[0] < thresholds[2]
    assert [sum(planner.shares[first::4]) for first in range(4)] == pytest.approx([1] * 4)


def test_questions_that_make_no_sense_are_refused(planner: MovingPlanner) -> None:
    with pytest.raises(ArgumentError, match="trials = 0"):
        planner.plan(planner.belt.belief(), trials=0)
    with pytest.raises(ArgumentError, match="no object is left"):
        planner.plan(planner.belt.belief(objects=0))
    other = MovingBelt(planner.belt.model, ticks_per_place=5)
    with pytest.raises(ArgumentError, match="another belt"):
        planner.plan(other.belief())


def test_a_belt_that_advances_on_decisions_is_refused() -> None:
    belt = MovingBelt(beltsort.models.paper(), advance_ticks=1)
    with pytest.raises(ArgumentError, match="advances on decisions"):
        MovingPlanner(belt)
