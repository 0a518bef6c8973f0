"""Threshold and InformationGain: when they decide and where they look."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from beltsort import ArgumentError, Belief, Decide, InformationGain, Move, SortingModel, Threshold
from beltsort.planning.named_policy import named_policy
from tests.laws import cases

from .models import random_belief, random_model

BLIND = np.full((2, 2), 0.5)
SHARP = np.array([[0.9, 0.1], [0.1, 0.9]])


def two_class_model(
    *tables: list[np.ndarray[tuple[int, int], np.dtype[np.float64]]], **settings: Any
) -> SortingModel:
    names = [f"v{i}" for i in range(len(tables[0]))]
    return SortingModel(["a", "b"], names, np.array(tables), **settings)


@pytest.mark.parametrize("policy_class", [Threshold, InformationGain])
def test_decides_exactly_at_the_threshold(policy_class: type[Threshold] | type[InformationGain]) -> None:
    model = two_class_model([SHARP])
    policy = policy_class(model, 0.75)
    assert policy.act(Belief(model, [[0.25, 0.75]]), 0) == Decide(1)
    assert policy.act(Belief(model, [[0.75, 0.25]]), 0) == Decide(0)
    assert policy.act(Belief(model, [[0.2500001, 0.7499999]]), 0) == Move(0)


def test_threshold_looks_from_the_most_informative_viewpoint() -> None:
    model = two_class_model([BLIND, SHARP])
    assert Threshold(model, 0.9).act(Belief(model), 0) == Move(1)
    assert Threshold(model, 0.9, viewpoint=0).act(Belief(model), 1) == Move(0)


def test_threshold_travels_by_the_fewest_moves() -> None:
    model = two_class_model([BLIND, BLIND, SHARP], travel=[[0, 1], [0, 2], [2]])
    policy = Threshold(model, 0.9)
    assert [policy.act(Belief(model), viewpoint) for viewpoint in range(3)] == [Move(1), Move(2), Move(2)]


def test_information_gain_counts_the_positions_it_is_told_to() -> None:
    model = two_class_model([SHARP, BLIND], [BLIND, np.eye(2)])
    assert InformationGain(model, 0.95).act(Belief(model), 0) == Move(0)
    assert InformationGain(model, 0.95, positions=2).act(Belief(model), 0) == Move(1)


def test_information_gain_knows_what_a_second_look_is_worth() -> None:
    other = np.array([[0.85, 0.15], [0.15, 0.85]])
    for repeat, expected in [(0.0, Move(0)), (0.9, Move(1))]:
        model = two_class_model([SHARP, other], repeat=repeat)
        belief = Belief(model)
        policy = InformationGain(model, 0.95)
        assert policy.act(belief, 0) == Move(0)
        belief.observe(0, [1])
        assert policy.act(belief, 0) == expected


def test_information_about_bins_does_not_tell_classes_of_one_bin_apart() -> None:
    """`left` tells nut from washer, which share a bin; `right` says a little about bolts."""
    left = [[0.95, 0.05], [0.05, 0.95], [0.5, 0.5]]
    right = [[0.7, 0.3], [0.7, 0.3], [0.3, 0.7]]
    model = SortingModel(
        ["nut", "washer", "bolt"],
        ["left", "right"],
        [[left, right]],
        labels=["yes", "no"],
        bins=["flat", "long"],
        reward=[[10.0, 10.0, -50.0], [-50.0, -50.0, 10.0]],
    )
    belief = Belief(model)
    assert InformationGain(model, 0.95).act(belief, 0) == Move(0)
    assert InformationGain(model, 0.95, about="class").act(belief, 0) == Move(0)
    assert InformationGain(model, 0.95, about="bin").act(belief, 0) == Move(1)
    assert named_policy("information-gain:0.95:1:bin", model).act(belief, 0) == Move(1)


@cases(40)
@given(seed=st.integers(0, 10_000))
def test_where_bins_are_classes_both_questions_are_one(seed: int) -> None:
    model = random_model(seed, k=3)
    belief = random_belief(model, seed)
    of_class, of_bin = InformationGain(model, 0.95), InformationGain(model, 0.95, about="bin")
    assert of_class.act(belief, 0) == of_bin.act(belief, 0)


def test_another_question_is_named() -> None:
    model = two_class_model([SHARP])
    with pytest.raises(ArgumentError, match=r'about = "colour", expected "class" or "bin"'):
        InformationGain(model, 0.9, about="colour")  # type: ignore[arg-type] # a wrong word on purpose
    with pytest.raises(ArgumentError, match="'colour' is neither class nor bin"):
        named_policy("information-gain:0.9:1:colour", model)


def test_decides_where_no_move_is_legal() -> None:
    model = two_class_model([BLIND], travel=[[]])
    belief = Belief(model, [[0.4, 0.6]])
    assert Threshold(model, 1.0).act(belief, 0) == InformationGain(model, 1.0).act(belief, 0) == Decide(1)


@cases(40)
@given(seed=st.integers(0, 10_000), threshold=st.sampled_from([0.5, 0.7, 1.0]))
def test_relabelling_the_classes_relabels_the_action(seed: int, threshold: float) -> None:
    model = random_model(seed, k=3)
    belief = random_belief(model, seed)
    order = np.random.default_rng(seed).permutation(3)
    renamed = SortingModel(
        [model.classes[c] for c in order], model.viewpoints, model.p_obs[:, :, order][..., order]
    )
    other = Belief(renamed, belief.probabilities[:, order])
    for policy_class in (Threshold, InformationGain):
        action = policy_class(model, threshold).act(belief, 0)
        renamed_action = policy_class(renamed, threshold).act(other, 0)
        if isinstance(renamed_action, Decide):
            renamed_action = Decide(int(order[renamed_action.label]))
        assert renamed_action == action
