"""How well looks tell classes apart."""

import numpy as np
import pytest

from beltsort import SortingModel
from beltsort.models import paper
from beltsort.planning.separation import (
    chernoff_information,
    class_tables,
    entropy_left,
    independent_looks,
    worst_separation,
)
from tests.core.models import named, random_model


@pytest.mark.parametrize("seed", range(5))
def test_chernoff_information_is_symmetric_and_between_its_bounds(seed: int) -> None:
    p, q = np.random.default_rng(seed).dirichlet(np.ones(4), size=2)
    information = chernoff_information(p, q)
    bhattacharyya = -np.log(np.sqrt(p * q).sum())
    assert information == pytest.approx(chernoff_information(q, p), abs=1e-6)
    divergences = [(p * np.log(p / q)).sum(), (q * np.log(q / p)).sum()]
    assert bhattacharyya - 1e-9 <= information <= min(divergences)


def test_distributions_without_a_common_label_are_told_apart_by_one_look() -> None:
    assert chernoff_information(np.array([1.0, 0.0]), np.array([0.0, 1.0])) == np.inf


@pytest.mark.parametrize("seed", range(3))
def test_relabelled_classes_have_the_same_worst_pair(seed: int) -> None:
    model = random_model(seed, n=4)
    order = np.random.default_rng(seed).permutation(4)
    names = [model.classes[c] for c in order]
    other = SortingModel(names, model.viewpoints, model.p_obs[:, :, order])
    found, again = worst_separation(model), worst_separation(other)
    assert found is not None
    assert again is not None
    assert set(found.classes) == set(again.classes)
    assert found.information == pytest.approx(again.information, abs=1e-6)
    assert (found.viewpoint, found.position) == (again.viewpoint, again.position)


def test_one_good_viewpoint_at_one_position_is_enough() -> None:
    tables = np.full((2, 2, 2, 2), 0.5)
    tables[1, 1] = [[0.9, 0.1], [0.1, 0.9]]
    worst = worst_separation(SortingModel(["a", "b"], ["left", "right"], tables))
    assert worst is not None
    assert (worst.viewpoint, worst.position) == ("right", 1)


def test_classes_of_one_bin_or_that_never_arrive_need_not_be_told_apart() -> None:
    tables = np.array([[[[0.5, 0.5, 0.0], [0.5, 0.5, 0.0], [0.0, 0.1, 0.9]]]])
    model = SortingModel(named("c", 3), ["v"], tables)
    worst = worst_separation(model)
    assert worst is not None
    assert (worst.classes, worst.looks) == (("c0", "c1"), None)
    reward = [[10.0, 10.0, -50.0], [-50.0, -50.0, 10.0]]
    together = SortingModel(named("c", 3), ["v"], tables, bins=["x", "y"], reward=reward)
    for other in (together, model.replace(arrival=[0.5, 0.0, 0.5])):
        worst = worst_separation(other)
        assert worst is not None
        assert "c2" in worst.classes
    assert worst_separation(model.replace(arrival=[0.0, 0.0, 1.0])) is None


def test_the_first_look_at_modes_is_their_mean() -> None:
    tables = np.array([[[[1.0, 0.0], [0.0, 1.0], [0.3, 0.7]]]])
    model = SortingModel(["a", "b"], ["v"], tables, modes=[[0.25, 0.75], [1.0]])
    np.testing.assert_allclose(class_tables(model)[0, 0], [[0.25, 0.75], [0.3, 0.7]])
    assert independent_looks(model).modes == [[1.0], [1.0]]


def test_entropy_falls_look_by_look_and_more_slowly_where_looks_repeat() -> None:
    model = paper()
    independent = entropy_left(model, 9)
    assert independent[0] == pytest.approx(1.0)
    assert (np.diff(independent) < 0.0).all()
    previous = independent
    for repeat in (0.3, 0.6, 0.9):
        left = entropy_left(model.replace(repeat=repeat), 9)
        # The first look from each of three viewpoints repeats none; those after it do.
        np.testing.assert_allclose(left[:4], independent[:4])
        assert left[-1] > previous[-1]
        previous = left


def test_nothing_is_uncertain_if_one_class_arrives() -> None:
    assert not entropy_left(paper().replace(arrival=[1.0, 0.0, 0.0, 0.0]), 2).any()
