"""MovingBelt and MovingBelief: durations, files, and what is known."""

import pickle
from pathlib import Path

import numpy as np
import pytest

import beltsort
from beltsort import ArgumentError, ModelError, MovingBelief, MovingBelt, SortingModel


@pytest.fixture
def belt() -> MovingBelt:
    return MovingBelt(beltsort.models.paper(), ticks_per_place=3, reach=2, scan_ticks=1, seconds_per_tick=0.5)


@pytest.mark.parametrize("drive", [{"ticks_per_place": 3}, {"advance_ticks": 2}])
def test_what_is_saved_or_pickled_is_loaded(tmp_path: Path, drive: dict[str, int]) -> None:
    belt = MovingBelt(
        beltsort.models.paper(), move_ticks=np.arange(9).reshape(3, 3), missed=[1, 2, 3, 0.1], **drive
    )
    belt.save(tmp_path / "belt.json")
    assert MovingBelt.load(tmp_path / "belt.json") == belt
    assert pickle.loads(pickle.dumps(belt)) == belt
    belief = belt.belief(objects=4)
    belief.observe("p2", [1, None])
    belief.decide(0)
    belief.advance_time(2)
    assert pickle.loads(pickle.dumps(belief)) == belief


def test_a_model_file_and_that_of_a_belt_are_told_apart(tmp_path: Path, belt: MovingBelt) -> None:
    belt.save(tmp_path / "belt.json")
    with pytest.raises(ModelError, match=r"belt\.json.*MovingBelt\.load"):
        SortingModel.load(tmp_path / "belt.json")
    belt.model.save(tmp_path / "model.json")
    with pytest.raises(ModelError, match=r"model\.json.*moving_belt"):
        MovingBelt.load(tmp_path / "model.json")


def test_a_look_takes_its_move_and_its_scan_and_at_least_one_tick() -> None:
    model = beltsort.models.paper()
    ticks = 1 - np.eye(3)
    assert MovingBelt(model, ticks_per_place=3, move_ticks=ticks).look_ticks.tolist() == [[1] * 3] * 3
    longer = MovingBelt(model, ticks_per_place=3, move_ticks=ticks, scan_ticks=2)
    assert longer.look_ticks.tolist() == [[2, 3, 3], [3, 2, 3], [3, 3, 2]]


def test_a_belief_is_its_parts(belt: MovingBelt) -> None:
    belief = belt.belief(objects=3)
    belief.observe("p1", ["livarno", "mushroom"])
    belief.decide(1)
    belief.advance_time(4)
    assert (belief.decided, belief.offset, belief.to_come, belief.is_over) == ([True, False], 1, 0, False)
    assert [belief.ticks_left(place) for place in (0, 1)] == [2, 5]
    assert belief == MovingBelief(belt, kinds=belief.kinds, decided=[True, False], offset=1, to_come=0)
    np.testing.assert_allclose(belief.probabilities.sum(axis=1), 1)
    assert belief.most_likely(0)[0] == belief.best_decision(0)[0] == belt.model.classes.index("mushroom")


def test_an_object_that_leaves_undecided_is_missed(belt: MovingBelt) -> None:
    belief = belt.belief()
    assert belief.advance_time(4) == pytest.approx(belt.missed[0] * belt.model.discount**3)


def test_a_belt_that_advances_on_decisions_does_nothing_else() -> None:
    belt = MovingBelt(beltsort.models.paper(), advance_ticks=2)
    belief = belt.belief(objects=3)
    belief.observe(0, [None, "standard"])
    before = belief.probabilities
    assert belief.advance_time(1000) == 0
    assert belief.ticks_left(0) is None
    np.testing.assert_array_equal(belief.probabilities, before)
    belief.decide(0)
    np.testing.assert_array_equal(belief.probabilities, [before[1], belt.model.arrival])
    assert (belief.to_come, belt.decision_ticks) == (0, 2)


@pytest.mark.parametrize(
    ("given", "named"),
    [
        ({}, "neither of ticks_per_place and advance_ticks"),
        ({"ticks_per_place": 3, "advance_ticks": 1}, "both"),
        ({"ticks_per_place": 0}, "ticks_per_place = 0"),
        ({"ticks_per_place": 3, "scan_ticks": -1}, "scan_ticks -1"),
        ({"ticks_per_place": 3, "reach": 3}, "reach = 3"),
        ({"ticks_per_place": 3, "missed": [1.0]}, "missed"),
        ({"ticks_per_place": 3, "move_ticks": 0.5}, "move_ticks has the entry 0.5"),
    ],
)
def test_durations_that_make_no_sense_are_refused(given: dict[str, int], named: str) -> None:
    with pytest.raises(ArgumentError, match=named):
        MovingBelt(beltsort.models.paper(), **given)  # type: ignore[arg-type]  # the mistake


def test_models_that_are_not_supported_are_refused() -> None:
    with pytest.raises(ModelError, match="repeat"):
        MovingBelt(beltsort.models.paper().replace(repeat=0.5), ticks_per_place=4)


def test_beliefs_that_do_not_fit_are_refused(belt: MovingBelt) -> None:
    with pytest.raises(ArgumentError, match="offset = 3"):
        MovingBelief(belt, offset=3)
    with pytest.raises(ArgumentError, match="places"):
        MovingBelief(belt, decided=[False])
    with pytest.raises(ArgumentError, match="probabilities"):
        MovingBelief(belt, kinds=[[0.5, 0.5]])
    belief = belt.belief()
    belief.decide(0)
    with pytest.raises(ArgumentError, match="decided already"):
        belief.decide(0)
    with pytest.raises(ArgumentError, match="index 2 of a position"):
        belief.decide(2)
