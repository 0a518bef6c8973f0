"""What a model promises, and belts that cannot be sorted."""

import json

import numpy as np
import pytest

from beltsort import OneObject, SortingModel, evaluate
from beltsort.models import paper
from beltsort.planning.expectation import Expectation, expectation
from beltsort.planning.model_changes import (
    changed_models,
    with_common_bin,
    with_manual_bin,
    with_viewpoint_like,
)
from beltsort.planning.separation import cheapest_look, class_tables, worst_separation

CHANCE = paper().replace(p_obs=np.full((2, 3, 4, 4), 0.25))


def two_alike() -> SortingModel:
    """Return the paper's model with its first two classes indistinguishable."""
    tables = paper().p_obs.copy()
    tables[:, :, 1] = tables[:, :, 0]
    return paper().replace(p_obs=tables)


def sticky() -> SortingModel:
    """Return a model whose objects look like one class or the other for good."""
    like = np.array([[0.95, 0.05], [0.05, 0.95]])
    tables = np.tile(like[[0, 1, 1, 0]], (1, 2, 1, 1))
    return SortingModel(["a", "b"], ["v", "w"], tables, modes=[[0.7, 0.3], [0.7, 0.3]])


def warned(found: Expectation, *parts: str) -> bool:
    return all(any(part in warning for warning in found.warnings) for part in parts)


@pytest.mark.parametrize("r_min", [5, 50, 500])
def test_the_papers_model_gives_no_warning(r_min: float) -> None:
    found = expectation(paper().replace(r_min=r_min))
    assert found.warnings == ()
    assert found.remedies == ()
    assert "Warning" not in str(found)


def test_what_is_promised_is_what_the_policy_reaches_on_other_objects() -> None:
    found = expectation(paper(), seed=5).simulated
    other = evaluate(paper(), OneObject(paper()), batches=400, seed=99)
    for mean, per_batch in ((found.right, other.correct), (found.looks, other.steps - np.uint64(10))):
        assert abs(mean.mean - per_batch.mean() / 10) < 4.0 * mean.error + 0.01


def test_chance_tables_are_forced_and_lose() -> None:
    found = expectation(CHANCE)
    assert found.simulated.forced.mean == 1.0
    assert warned(found, "forced", "sorting loses", "cannot be told apart")
    assert not warned(found, "repeat each other")  # there is nothing to repeat
    assert "manual" in found.remedies[0].change
    assert found.remedies[0].simulated.forced.mean == 0.0


def test_two_identical_classes_belong_into_one_bin() -> None:
    found = expectation(two_alike())
    assert warned(found, "elongated and livarno cannot be told apart")
    assert "one bin for elongated and livarno" in found.remedies[0].change
    assert found.remedies[0].simulated.right.mean > 0.9


@pytest.mark.parametrize("model", [sticky(), paper().replace(repeat=0.95)], ids=["modes", "repeat"])
def test_looks_that_only_repeat_are_named(model: SortingModel) -> None:
    found = expectation(model)
    assert warned(found, "looks repeat each other")
    assert found.left > found.left_if_independent + 0.1


def test_a_little_repetition_gives_no_warning() -> None:
    assert expectation(paper().replace(repeat=0.13)).warnings == ()


def test_it_is_reproducible_and_plain_data() -> None:
    found = expectation(CHANCE, seed=3)
    assert found == expectation(CHANCE, seed=3)
    json.dumps(found.to_dict(), allow_nan=False)
    certain = SortingModel(["a", "b"], ["v"], [[[[1.0, 0.0], [0.0, 1.0]]]])
    json.dumps(expectation(certain).to_dict(), allow_nan=False)


def test_a_limit_on_looks_forces_decisions() -> None:
    assert warned(expectation(paper(), max_looks=1), "forced by max_looks = 1")


@pytest.mark.parametrize("model", [CHANCE, two_alike(), sticky(), paper().replace(repeat=0.95)])
def test_no_look_is_for_ever_with_a_manual_bin_cheaper_than_a_look(model: SortingModel) -> None:
    """Looking for ever costs cost / (1 - discount), sending every object to the manual bin less."""
    with_bin = with_manual_bin(model.replace(repeat=0.0), 0.5 * cheapest_look(model))
    assert evaluate(with_bin, OneObject(with_bin), batches=20, threads=1).forced.sum() == 0


def test_changes_keep_what_they_do_not_change() -> None:
    model = sticky()
    worst = worst_separation(model)
    for _, changed in changed_models(model, worst):
        tables = class_tables(changed)
        np.testing.assert_allclose(tables[:, :2], class_tables(model))
        assert changed.classes == model.classes


def test_another_viewpoint_sees_like_its_model_and_is_as_far() -> None:
    model = paper().replace(
        motion_cost=[[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0]], travel=[[0, 1], [1], [0, 2]]
    )
    more = with_viewpoint_like(model, "p2")
    assert more is not None
    np.testing.assert_allclose(more.p_obs[:, 3], model.p_obs[:, 1])
    assert more.motion_cost[3].tolist() == [4.0, 5.0, 6.0, 5.0]
    assert more.motion_cost[:, 3].tolist() == [2.0, 5.0, 8.0, 5.0]
    assert [list(ends) for ends in more.travel] == [[0, 1, 3], [1, 3], [0, 2], [1, 3]]


def test_the_new_viewpoints_modes_are_independent_of_the_others() -> None:
    more = with_viewpoint_like(sticky(), "v")
    assert more is not None
    np.testing.assert_allclose(more.modes[0], [0.49, 0.21, 0.21, 0.09])
    for first in range(2):
        own = more.p_obs[0, :, 2 * first : 2 * first + 2]  # modes of the others the same, of the new one both
        np.testing.assert_allclose(own[:2, 0], own[:2, 1])
        np.testing.assert_allclose(own[2], sticky().p_obs[0, 0, :2])
    assert with_viewpoint_like(more, "v") is not None
    assert (
        with_viewpoint_like(more.replace(modes=[[1 / 8] * 8] * 2, p_obs=np.full((1, 3, 16, 2), 0.5)), "v")
        is None
    )


def test_a_common_bin_is_worth_the_better_of_two() -> None:
    merged = with_common_bin(paper(), ("livarno", "standard"))
    assert merged is not None
    assert merged.bins == ["elongated", "mushroom", "livarno or standard"]
    assert merged.reward[2].tolist() == [-50.0, 10.0, -50.0, 10.0]
    assert with_common_bin(merged, ("livarno", "standard")) is None
    assert with_common_bin(sticky(), ("a", "b")) is None  # nothing would be left to sort
