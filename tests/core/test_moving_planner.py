"""MovingPlanner: plans for a belt that never stops."""

import pickle

import pytest

import beltsort
from beltsort import ArgumentError, Belief, DecideAt, ModelError, MovingPlanner


@pytest.fixture(scope="module")
def planner() -> MovingPlanner:
    return MovingPlanner(beltsort.models.paper(), ticks_per_place=4, reach=2, trials=20)


def test_a_plan_is_a_function_of_its_arguments_also_of_a_pickled_planner(planner: MovingPlanner) -> None:
    belief = Belief(planner.model)
    plans = [p.plan(belief, offset=2, to_come=3) for p in (planner, pickle.loads(pickle.dumps(planner)))]
    assert plans[0].values == plans[1].values
    assert plans[0].lower <= plans[0].upper


def test_what_is_certain_is_decided_unless_it_is_decided_already(planner: MovingPlanner) -> None:
    belief = Belief(planner.model, [[0.25] * 4, [0.0, 0.0, 1.0, 0.0]])
    assert planner.plan(belief).action == DecideAt(1, 2)
    assert planner.plan(belief, decided=[1]).action != DecideAt(1, 2)


def test_a_threshold_falls_at_the_exit_and_shares_sum_to_one(planner: MovingPlanner) -> None:
    thresholds = planner.thresholds(0)
    assert len(thresholds) == 8
    assert thresholds[0] is not None
    assert thresholds[2] is not None
    assert thresholds[0] < thresholds[2]
    assert [sum(planner.shares[first::4]) for first in range(4)] == pytest.approx([1] * 4)


@pytest.mark.parametrize(
    ("given", "named"), [({"offset": 4}, "offset"), ({"decided": [2]}, "decided"), ({"trials": 0}, "trials")]
)
def test_questions_that_make_no_sense_are_refused(
    planner: MovingPlanner, given: dict[str, int], named: str
) -> None:
    with pytest.raises(ArgumentError, match=named):
        planner.plan(Belief(planner.model), **given)  # type: ignore[arg-type]  # the mistake


def test_models_that_are_not_supported_are_refused() -> None:
    model = beltsort.models.paper().replace(repeat=0.5)
    with pytest.raises(ModelError, match="repeat"):
        MovingPlanner(model, ticks_per_place=4)
