"""Belief: the factored arithmetic equals that of the joint distribution."""

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from beltsort import Belief, ImpossibleObservationError, SortingModel
from tests.laws import cases

from .models import random_belief, random_model

Joint = NDArray[np.float64]  # (L,) * H
SEEDS = st.integers(0, 10_000)
CERTAIN, UNKNOWN = [1.0, 0.0, 0.0, 0.0], [0.25] * 4


def joint_of(belief: Belief) -> Joint:
    joint = np.ones(())
    for row in belief.probabilities:
        joint = np.multiply.outer(joint, row)
    return joint


def observed(joint: Joint, model: SortingModel, viewpoint: int, labels: list[int | None]) -> Joint:
    posterior = joint.copy()
    for classes in np.ndindex(joint.shape):
        for j, label in enumerate(labels):
            if label is not None:
                posterior[classes] *= model.p_obs[j, viewpoint, classes[j], label]
    return np.asarray(posterior / posterior.sum())


def advanced(joint: Joint, model: SortingModel) -> Joint:
    return np.asarray(np.multiply.outer(joint.sum(axis=0), model.arrival))


def marginals(joint: Joint) -> list[NDArray[np.float64]]:
    axes = range(joint.ndim)
    return [joint.sum(axis=tuple(a for a in axes if a != j)) for j in axes]


@cases(40)
@given(seed=SEEDS, h=st.integers(1, 3), k=st.integers(1, 3), n=st.integers(2, 4))
def test_equals_the_joint(seed: int, h: int, k: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    model = random_model(seed, h, k, n, arrival=rng.dirichlet(np.ones(n)).tolist())
    belief = random_belief(model, seed)
    joint = joint_of(belief)
    for _ in range(6):
        if rng.random() < 0.3:
            belief.advance()
            joint = advanced(joint, model)
        else:
            viewpoint = int(rng.integers(k))
            labels = [None if rng.random() < 0.3 else int(rng.integers(n)) for _ in range(h)]
            belief.observe(viewpoint, labels)
            joint = observed(joint, model, viewpoint, labels)
        np.testing.assert_allclose(belief.probabilities, marginals(joint), atol=1e-12)
        np.testing.assert_allclose(belief.probabilities.sum(axis=1), 1.0, atol=1e-12)


@cases(20)
@given(seed=SEEDS)
def test_label_probabilities(seed: int) -> None:
    model = random_model(seed)
    belief = random_belief(model, seed)
    for viewpoint in range(2):
        expected = np.einsum("jc,jcz->jz", belief.probabilities, model.p_obs[:, viewpoint])
        np.testing.assert_allclose(belief.label_probabilities(viewpoint), expected, atol=1e-14)


@cases(20)
@given(seed=SEEDS)
def test_relabelling_the_classes_relabels_the_belief(seed: int) -> None:
    model = random_model(seed)
    order = np.random.default_rng(seed).permutation(3)
    renamed = SortingModel(
        [model.classes[c] for c in order], model.viewpoints, model.p_obs[:, :, order][..., order]
    )
    new_label = np.argsort(order)
    belief, other = Belief(model), Belief(renamed)
    for viewpoint, labels in [(0, [0, 1]), (1, [2, 2])]:
        belief.observe(viewpoint, labels)
        other.observe(viewpoint, [int(new_label[z]) for z in labels])
    np.testing.assert_allclose(other.probabilities, belief.probabilities[:, order], atol=1e-12)


def test_starts_from_the_arrival_prior() -> None:
    model = random_model(0, arrival=[0.2, 0.3, 0.5])
    assert Belief(model).probabilities == pytest.approx(np.array([[0.2, 0.3, 0.5]] * 2))


def test_impossible_label_leaves_the_belief_unchanged(paper: SortingModel) -> None:
    belief = Belief(paper, np.array([CERTAIN, UNKNOWN]))
    before = belief.probabilities
    with pytest.raises(ImpossibleObservationError) as raised:
        belief.observe(0, [2, 1])
    assert re.search("position 1.*p1.*mushroom", str(raised.value))
    assert np.array_equal(belief.probabilities, before)


def test_an_impossible_label_behind_a_possible_one_changes_nothing(paper: SortingModel) -> None:
    belief = Belief(paper, np.array([UNKNOWN, CERTAIN]))
    before = belief.probabilities
    with pytest.raises(ImpossibleObservationError, match=r"position 2.*p3.*standard"):
        belief.observe(2, [0, 3])
    assert np.array_equal(belief.probabilities, before)


def test_copies_are_independent(paper: SortingModel) -> None:
    belief = Belief(paper)
    copy = belief.copy()
    copy.observe(0, [0, 0])
    assert np.array_equal(belief.probabilities, Belief(paper).probabilities)
    belief.probabilities[:] = 0
    assert belief.probabilities.sum() == pytest.approx(2.0)


def test_most_likely(paper: SortingModel) -> None:
    belief = Belief(paper, np.array([[0.1, 0.4, 0.4, 0.1], [0, 0, 0, 1]]))
    assert belief.most_likely(0) == (1, 0.4)
    assert belief.most_likely(1) == (3, 1.0)


def mixed(model: SortingModel, viewpoint: int, last: int, j: int = 0) -> NDArray[np.float64]:
    """P(z' | z, v, c) of one position by the definition of `repeat`, shape (L, L)."""
    repeat = model.repeat[j, viewpoint]
    return np.asarray(repeat * np.eye(3)[last] + (1 - repeat) * model.p_obs[j, viewpoint])


@cases(30)
@given(seed=SEEDS, first=st.integers(0, 2), second=st.integers(0, 2), repeat=st.floats(0.01, 0.99))
def test_a_second_look_from_the_same_viewpoint(seed: int, first: int, second: int, repeat: float) -> None:
    model = random_model(seed, h=1, repeat=repeat)
    belief = random_belief(model, seed)
    prior = belief.probabilities[0]
    belief.observe(0, [first])
    once = prior * model.p_obs[0, 0, :, first]
    twice = once * mixed(model, 0, first)[:, second]
    np.testing.assert_allclose(belief.label_probabilities(0)[0], once @ mixed(model, 0, first) / once.sum())
    belief.observe(0, [second])
    np.testing.assert_allclose(belief.probabilities[0], twice / twice.sum(), atol=1e-12)


def test_only_a_look_from_the_same_viewpoint_repeats() -> None:
    plain, model = random_model(0), random_model(0, repeat=[[0.9, 0.0], [0.9, 0.0]])
    belief, expected = Belief(model), Belief(plain)
    for viewpoint in (0, 1, 1):
        belief.observe(viewpoint, [2, 1])
        expected.observe(viewpoint, [2, 1])
    assert np.array_equal(belief.probabilities, expected.probabilities)
    assert belief.last_labels.tolist() == [[2, -1], [1, -1]]


def test_memory_keeps_the_last_label_until_the_belt_moves() -> None:
    model = random_model(0, repeat=0.5)
    belief = Belief(model)
    belief.observe(0, [1, 2])
    belief.observe(0, [None, 0])
    assert belief.last_labels.tolist() == [[1, -1], [0, -1]]
    belief.advance()
    assert belief.last_labels.tolist() == [[-1, -1], [-1, -1]]


def test_a_belief_is_rebuilt_from_its_record() -> None:
    model = random_model(0, repeat=0.5)
    belief = Belief(model)
    belief.observe(1, [1, 2])
    again = Belief(model, belief.probabilities.tolist(), belief.last_labels.tolist())
    assert again == belief
    assert again != Belief(model, belief.probabilities)
    assert repr(again).splitlines()[-2:] == [
        "  last labels of position 1: c1 from v1",
        "  last labels of position 2: c2 from v1",
    ]
    again.observe(1, [1, 1])
    assert again != belief
    belief.observe(1, [1, 1])
    assert again == belief


def test_objects_left_are_counted_down() -> None:
    model = random_model(0)
    belief = Belief(model, remaining=2)
    assert belief != Belief(model)
    assert repr(belief).startswith("Belief, 2 objects left\n")
    belief.advance()
    assert belief.remaining == 1
    assert belief.copy().remaining == 1
    belief.observe(0, [1, 0])
    assert belief == Belief(model, belief.probabilities, remaining=1)
    assert Belief(model).remaining is None


def test_without_repeats_nothing_is_remembered(paper: SortingModel) -> None:
    belief = Belief(paper)
    belief.observe(0, [0, 0])
    assert np.all(belief.last_labels == -1)
    assert "last labels" not in repr(belief)
