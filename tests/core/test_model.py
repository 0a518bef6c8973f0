"""SortingModel: what is put in comes out, on every way round."""

import json
import pickle
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from beltsort import Belief, Decide, ModelError, Move, SortingModel

from .models import beyond_model, random_model

FULL = random_model(
    1,
    r_max=7.0,
    r_min=3.5,
    motion_cost=[[0.0, 1.0], [2.0, 0.5]],
    discount=0.9,
    arrival=[0.5, 0.25, 0.25],
    travel=[[1, 0], []],
    observe_after_decision=True,
    repeat=[[0.0, 0.5], [0.25, 0.9]],
    information_gain=0.3,
    empty="c2",
    counts=np.arange(36).reshape(2, 2, 3, 3),
    smoothing=0.5,
    note="ü",
)

BEYOND = beyond_model(
    3,
    arrival=[0.5, 0.25, 0.25],
    repeat=0.25,
    empty="c2",
    counts=np.arange(32).reshape(2, 2, 4, 2),
)


def through_file(model: SortingModel, folder: Path) -> SortingModel:
    model.save(folder / "model.json")
    return SortingModel.load(folder / "model.json")


def through_pickle(model: SortingModel, _: Path) -> SortingModel:
    copy = pickle.loads(pickle.dumps(model))
    assert isinstance(copy, SortingModel)
    return copy


def through_json(model: SortingModel, _: Path) -> SortingModel:
    return SortingModel.from_json(model.to_json())


@pytest.mark.parametrize("way", [through_file, through_json, through_pickle])
@pytest.mark.parametrize("model", [FULL, BEYOND, random_model(2, h=1, k=1, n=2)])
def test_round_trip(
    way: Callable[[SortingModel, Path], SortingModel], model: SortingModel, tmp_path: Path
) -> None:
    again = way(model, tmp_path)
    assert again == model
    assert np.array_equal(again.p_obs, model.p_obs)
    assert again.note == model.note
    assert (again.labels, again.bins, again.modes) == (model.labels, model.bins, model.modes)
    assert np.array_equal(again.reward, model.reward)
    assert again != random_model(3)


def test_properties() -> None:
    assert FULL.classes == ["c0", "c1", "c2"]
    assert FULL.viewpoints == ["v0", "v1"]
    assert (FULL.positions, FULL.r_max, FULL.r_min, FULL.discount) == (2, 7.0, 3.5, 0.9)
    assert (FULL.smoothing, FULL.note) == (0.5, "ü")
    assert FULL.motion_cost.tolist() == [[0.0, 1.0], [2.0, 0.5]]
    assert FULL.arrival.tolist() == [0.5, 0.25, 0.25]
    assert FULL.travel == [[0, 1], []]
    assert FULL.repeat.tolist() == [[0.0, 0.5], [0.25, 0.9]]
    assert (FULL.observe_after_decision, FULL.information_gain, FULL.empty) == (True, 0.3, "c2")
    assert FULL.counts is not None
    assert FULL.counts.dtype == np.uint64
    assert FULL.counts[1, 1, 2, 2] == 35


def test_keys_beyond_the_paper() -> None:
    assert (BEYOND.labels, BEYOND.bins) == (["seen, sure", "seen"], ["one", "manual"])
    assert BEYOND.reward.tolist() == [[10.0, 5.0, -50.0], [-3.0, -3.0, 2.0]]
    assert (BEYOND.r_max, BEYOND.r_min) == (10.0, 50.0)
    assert BEYOND.modes == [[1.0], [0.25, 0.75], [1.0]]
    assert BEYOND.p_obs.shape == (2, 2, 4, 2)
    assert Belief(BEYOND).kinds == pytest.approx(np.array([[0.5, 0.0625, 0.1875, 0.25]] * 2))
    assert Belief(BEYOND).probabilities == pytest.approx(np.array([[0.5, 0.25, 0.25]] * 2))


def test_without_new_keys_labels_and_bins_are_the_classes() -> None:
    assert FULL.labels == FULL.bins == FULL.classes
    assert FULL.modes == [[1.0]] * 3
    assert FULL.reward.tolist() == np.where(np.eye(3, dtype=bool), 7.0, -3.5).tolist()
    assert not {"labels", "bins", "reward", "modes"} & set(json.loads(FULL.to_json()))


def test_a_reward_takes_the_place_of_r_max_and_r_min_in_the_file() -> None:
    assert not {"r_max", "r_min"} & set(json.loads(BEYOND.to_json()))


def test_defaults() -> None:
    model = random_model(0)
    assert (model.r_max, model.r_min, model.discount, model.note) == (10.0, 50.0, 0.95, "")
    assert np.array_equal(model.motion_cost, np.ones((2, 2)))
    assert model.travel == [[0, 1], [0, 1]]
    assert model.arrival == pytest.approx(1 / 3)
    assert model.counts is None
    assert model.smoothing is None
    assert np.array_equal(model.repeat, np.zeros((2, 2)))
    assert (model.observe_after_decision, model.information_gain, model.empty) == (False, 0.0, None)


def test_one_repeat_for_all() -> None:
    assert np.array_equal(random_model(0, repeat=0.5).repeat, np.full((2, 2), 0.5))


def test_arrays_are_read_only() -> None:
    for array in (FULL.p_obs, FULL.counts):
        assert array is not None
        with pytest.raises(ValueError, match="read-only"):
            array[0, 0, 0, 0] = 1


def test_rows_are_kept_as_given_and_normalised_in_the_arithmetic() -> None:
    model = SortingModel(["a", "b"], ["v"], [[[[0.5, 0.5000004], [0.1, 0.9]]]])
    assert model.p_obs[0, 0, 0, 1] == 0.5000004
    belief = Belief(model, [[1.0, 0.0]])
    assert belief.label_probabilities(0).sum() == pytest.approx(1.0, abs=1e-15)


def test_fewer_positions() -> None:
    one = FULL.with_positions(1)
    assert one.positions == 1
    assert np.array_equal(one.p_obs, FULL.p_obs[:1])
    assert one.counts is not None
    assert one.counts.shape == (1, 2, 3, 3)
    assert one.repeat.tolist() == [[0.0, 0.5]]


def test_fewer_positions_keep_every_other_key() -> None:
    one = BEYOND.with_positions(1)
    assert one.p_obs.shape == (1, 2, 4, 2)
    counts = BEYOND.counts
    assert counts is not None
    assert one == BEYOND.replace(p_obs=BEYOND.p_obs[:1], counts=counts[:1], smoothing=BEYOND.smoothing)


def test_pseudo_counts_of_every_entry_are_kept() -> None:
    model = FULL.replace(smoothing=np.full(FULL.p_obs.shape, 0.5))
    assert SortingModel.from_json(model.to_json()) == model
    assert isinstance(model.smoothing, np.ndarray)
    assert model.smoothing.shape == FULL.p_obs.shape
    one = model.with_positions(1).smoothing
    assert isinstance(one, np.ndarray)
    assert one.shape == (1, *FULL.p_obs.shape[1:])


def test_a_new_table_comes_without_the_counts_of_the_old_one() -> None:
    changed = FULL.replace(p_obs=FULL.p_obs[..., ::-1])
    assert (FULL.counts is not None, changed.counts, changed.smoothing) == (True, None, None)


def test_replaced_keys_beyond_the_paper() -> None:
    dearer = BEYOND.replace(reward=[[10.0, 5.0, -500.0], [-3.0, -3.0, 2.0]])
    assert dearer.r_min == 500.0
    assert dearer.replace(reward=BEYOND.reward) == BEYOND
    even = BEYOND.replace(modes=[[1.0], [0.5, 0.5], [1.0]])
    assert Belief(even).kinds[0] == pytest.approx(np.array([0.5, 0.125, 0.125, 0.25]))
    plain = BEYOND.replace(bins=None, reward=None, r_min=7)
    assert (plain.bins, plain.r_min, plain.labels) == (plain.classes, 7.0, BEYOND.labels)
    with pytest.raises(ModelError, match="r_min"):
        BEYOND.replace(r_min=7)


def test_replaced_settings_are_the_only_ones_that_change() -> None:
    changed = FULL.replace(r_min=7, note="seven")
    assert (changed.r_min, changed.note) == (7.0, "seven")
    assert changed.replace(r_min=FULL.r_min, note=FULL.note) == FULL
    assert FULL.replace() == FULL
    with pytest.raises(ModelError, match="r_min"):
        FULL.replace(r_min=-1)
    with pytest.raises(TypeError, match="rmin"):
        FULL.replace(rmin=1)


def test_a_model_file_has_the_names_of_the_constructor() -> None:
    keys = json.loads(FULL.to_json())
    p_obs = keys.pop("p_obs")
    assert len(keys) == 15
    again = SortingModel(keys.pop("classes"), keys.pop("viewpoints"), p_obs, **keys)
    assert again == FULL


def test_actions_are_values() -> None:
    assert pickle.loads(pickle.dumps([Move(2), Decide(1)])) == [Move(2), Decide(1)]
    assert len({Move(1), Move(1), Decide(1), Move(0)}) == 3
