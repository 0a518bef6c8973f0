"""to_pomdp: the file is the model, whoever reads it."""

import itertools
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from beltsort import Belief, ModelError, SortingModel
from tests.laws import cases

from .models import arrival_of_kinds, beyond_model, class_of_kinds, named, random_belief, random_model
from .pomdp_reader import Pomdp, read_pomdp

Floats = NDArray[np.float64]
NOTHING = -1  # the last observation
law = cases(40)


def exported(model: SortingModel) -> Pomdp:
    with TemporaryDirectory() as folder:
        path = Path(folder) / "model.pomdp"
        model.to_pomdp(path)
        return read_pomdp(path.read_text())


PAPER_REWARDS: st.SearchStrategy[dict[str, Any]] = st.fixed_dictionaries(
    {"r_max": st.floats(0.5, 20), "r_min": st.floats(0.5, 100)}
)


@st.composite
def beyond(draw: st.DrawFn, n: int, rng: np.random.Generator) -> dict[str, Any]:
    """Keys that the paper's model does not have."""
    bins = draw(st.integers(1, 3))
    reward = rng.uniform(-20, 20, (bins, n))
    reward[0, 0] = 10.0
    return {
        "labels": named("label ", draw(st.integers(1, 3))),
        "bins": named("bin ", bins),
        "reward": reward,
        "modes": [[1.0], [0.25, 0.75], [1.0]][:n] if draw(st.booleans()) else [[1.0]] * n,
    }


@st.composite
def models(draw: st.DrawFn) -> SortingModel:
    """Small models: some with zeros in the tables, restricted travel, cost matrices, arrival priors, and keys
    beyond the paper.
    """
    h, k, n = draw(st.integers(1, 2)), draw(st.integers(1, 3)), draw(st.integers(2, 3))
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    settings = draw(PAPER_REWARDS | beyond(n, rng))
    kinds = sum(len(weights) for weights in settings.get("modes", [[1.0]] * n))
    p_obs = rng.dirichlet(np.ones(len(settings.get("labels", range(n)))), size=(h, k, kinds))
    p_obs[p_obs < draw(st.sampled_from([0.0, 0.1]))] = 0.0
    p_obs /= p_obs.sum(axis=-1, keepdims=True)
    moves = st.lists(st.integers(0, k - 1), unique=True)
    arrival = rng.dirichlet(np.ones(n)).tolist() if draw(st.booleans()) else None
    return SortingModel(
        named("class ", n),
        named("viewpoint #", k),
        p_obs,
        **settings,
        discount=draw(st.floats(0.3, 0.99)),
        motion_cost=rng.uniform(0, 3, (k, k)) if draw(st.booleans()) else draw(st.sampled_from([0.0, 1.0])),
        travel=draw(st.none() | st.lists(moves, min_size=k, max_size=k)),
        arrival=arrival,
        observe_after_decision=draw(st.booleans()),
    )


def kind_vectors(model: SortingModel) -> list[tuple[int, ...]]:
    """Every vector of kinds, in the order of the file."""
    return list(itertools.product(range(model.p_obs.shape[2]), repeat=model.positions))


def label_vectors(model: SortingModel) -> list[tuple[int, ...]]:
    """Every vector of labels, in the order of the file."""
    return list(itertools.product(range(len(model.labels)), repeat=model.positions))


def joint(rows: Floats) -> Floats:
    """The joint distribution of independent positions, (H, N) -> (N^H,); or of their tables."""
    result = rows[0]
    for row in rows[1:]:
        result = np.kron(result, row)
    return np.asarray(result)


def move_reward(model: SortingModel, start: int, end: int) -> float:
    if end in model.travel[start]:
        return -float(model.motion_cost[start, end])
    return -(model.r_max + model.r_min) / (1 - model.discount)


def is_flat(model: SortingModel) -> bool:
    """Whether every viewpoint offers the same moves at the same costs, and nothing is seen unmoved."""
    costs = [{end: model.motion_cost[k, end] for end in moves} for k, moves in enumerate(model.travel)]
    alike = all(other == costs[0] for other in costs)
    return len(costs) == 1 or (alike and not model.observe_after_decision)


def told_apart(model: SortingModel) -> int:
    return 1 if is_flat(model) else len(model.viewpoints)


@law
@given(models())
def test_sets_start_and_discount(model: SortingModel) -> None:
    pomdp = exported(model)
    k, bins, viewpoints = len(model.viewpoints), len(model.bins), told_apart(model)
    assert (pomdp.discount, pomdp.values) == (model.discount, "reward")
    assert pomdp.actions == [f"move_{v}" for v in range(k)] + [f"decide_{b}" for b in range(bins)]
    assert ("nothing" in pomdp.observations) is not model.observe_after_decision
    assert len(pomdp.observations) == len(label_vectors(model)) + (not model.observe_after_decision)
    assert len(pomdp.states) == viewpoints * len(kind_vectors(model))
    first = joint(np.tile(arrival_of_kinds(model), (model.positions, 1)))
    assert pomdp.start == pytest.approx(np.concatenate([first, np.zeros((viewpoints - 1) * len(first))]))


@law
@given(models())
def test_transitions(model: SortingModel) -> None:
    transitions = exported(model).transitions
    states = list(itertools.product(range(told_apart(model)), kind_vectors(model)))
    k, arrival = len(model.viewpoints), arrival_of_kinds(model)
    for s, (viewpoint, kinds) in enumerate(states):
        for end in range(k):
            after = (end if told_apart(model) > 1 else 0, kinds)
            assert transitions[end, s].tolist() == [float(state == after) for state in states]
        decided = [
            arrival[new[-1]] if (at, new[:-1]) == (viewpoint, kinds[1:]) else 0.0 for at, new in states
        ]
        for decide in transitions[k:, s]:
            assert decide == pytest.approx(decided)


@law
@given(models())
def test_observations(model: SortingModel) -> None:
    labels = exported(model).labels
    k, viewpoints = len(model.viewpoints), told_apart(model)
    assert labels.sum(axis=-1) == pytest.approx(1.0)
    scans = [joint(model.p_obs[:, end]) for end in range(k)]  # (N^H, Z^H) each
    if not model.observe_after_decision:
        assert np.all(labels[:k, :, NOTHING] == 0)
        assert np.all(labels[k:, :, NOTHING] == 1)
    for end in range(k):
        seen = labels[end, :, : len(label_vectors(model))]
        assert seen == pytest.approx(np.tile(scans[end], (viewpoints, 1)))
    if model.observe_after_decision:
        for decide in labels[k:]:
            assert decide == pytest.approx(np.concatenate(scans))


@law
@given(models())
def test_rewards(model: SortingModel) -> None:
    rewards = exported(model).rewards
    assert np.array_equal(rewards, np.broadcast_to(rewards[:, :, :1, :1], rewards.shape))
    k, class_of = len(model.viewpoints), class_of_kinds(model)
    for s, (start, kinds) in enumerate(itertools.product(range(told_apart(model)), kind_vectors(model))):
        moves = [move_reward(model, start, end) for end in range(k)]
        decisions = model.reward[:, class_of[kinds[0]]].tolist()
        assert rewards[:, s, 0, 0] == pytest.approx([*moves, *decisions])


def flat_belief(model: SortingModel, belief: Belief, viewpoint: int) -> Floats:
    """The belief over the states of the file."""
    here = joint(belief.kinds)
    if is_flat(model):
        return here
    return np.kron(np.eye(len(model.viewpoints))[viewpoint], here)


def updated(pomdp: Pomdp, belief: Floats, action: int, observation: int) -> tuple[float, Floats]:
    """Probability of an observation, and the belief after it."""
    unnormalised = (belief @ pomdp.transitions[action]) * pomdp.labels[action, :, observation]
    probability = float(unnormalised.sum())
    return probability, unnormalised / probability if probability > 0 else unnormalised


@law
@given(models(), st.integers(0, 2**32), st.data())
def test_belief_updates(model: SortingModel, seed: int, data: st.DataObject) -> None:
    pomdp, belief = exported(model), random_belief(model, seed)
    viewpoint = data.draw(st.integers(0, len(model.viewpoints) - 1))
    flat = flat_belief(model, belief, viewpoint)
    for _ in range(3):
        decides = data.draw(st.booleans())
        if decides:
            belief.advance()
        else:
            viewpoint = data.draw(st.integers(0, len(model.viewpoints) - 1))
        action = len(model.viewpoints) if decides else viewpoint
        if decides and not model.observe_after_decision:
            _, flat = updated(pomdp, flat, action, NOTHING)
        else:
            predicted = joint(belief.label_probabilities(viewpoint))
            seen = data.draw(st.sampled_from(np.flatnonzero(predicted > 1e-3).tolist()))
            probability, flat = updated(pomdp, flat, action, seen)
            belief.observe(viewpoint, label_vectors(model)[seen])
            assert probability == pytest.approx(predicted[seen])
        assert flat == pytest.approx(flat_belief(model, belief, viewpoint))


def optimum_of_file(pomdp: Pomdp, belief: Floats, steps: int) -> float:
    if steps == 0:
        return 0.0
    values = []
    for action, transitions in enumerate(pomdp.transitions):
        value = float(
            np.einsum("s,st,tz,stz", belief, transitions, pomdp.labels[action], pomdp.rewards[action])
        )
        for observation in range(len(pomdp.observations)):
            probability, after = updated(pomdp, belief, action, observation)
            value += pomdp.discount * probability * optimum_of_file(pomdp, after, steps - 1)
        values.append(value)
    return max(values)


def optimum(model: SortingModel, belief: Belief, viewpoint: int, steps: int) -> float:
    """The same by the arithmetic of sorting, with legal moves only."""
    if steps == 0:
        return 0.0
    after = belief.copy()
    after.advance()
    follow = after_scan if model.observe_after_decision else optimum
    values = [
        float(np.max(model.reward @ belief.probabilities[0]))
        + model.discount * follow(model, after, viewpoint, steps - 1)
    ]
    for end in model.travel[viewpoint]:
        ahead = after_scan(model, belief, end, steps - 1)
        values.append(model.discount * ahead - float(model.motion_cost[viewpoint, end]))
    return max(values)


def after_scan(model: SortingModel, belief: Belief, viewpoint: int, steps: int) -> float:
    value = 0.0
    for labels, p in zip(label_vectors(model), joint(belief.label_probabilities(viewpoint)), strict=True):
        if p > 0:
            after = belief.copy()
            after.observe(viewpoint, labels)
            value += p * optimum(model, after, viewpoint, steps)
    return value


@pytest.mark.parametrize(
    ("h", "k", "travel"),
    [(1, 2, None), (2, 1, None), (1, 3, [[1], [2], []]), (2, 2, [[1], [0, 1]])],
)
@pytest.mark.parametrize("scan", [False, True])
@pytest.mark.parametrize("of_the_paper", [False, True])
def test_value_iteration(
    h: int, k: int, travel: list[list[int]] | None, scan: bool, of_the_paper: bool
) -> None:
    settings: dict[str, Any] = {"travel": travel, "observe_after_decision": scan}
    if of_the_paper:
        model = random_model(h, h=h, k=k, n=2, r_min=15.0, arrival=[0.4, 0.6], **settings)
    else:
        model = beyond_model(h, h=h, k=k, arrival=[0.4, 0.4, 0.2], **settings)
    pomdp = exported(model)
    for steps in (1, 2, 3):
        expected = optimum(model, Belief(model), 0, steps)
        assert optimum_of_file(pomdp, pomdp.start, steps) == pytest.approx(expected)


def test_too_many_states_are_refused(tmp_path: Path) -> None:
    model = random_model(0, h=8, k=1, n=3)
    with pytest.raises(ModelError, match=r"1 \* 3\^8.*2000000.*with_positions"):
        model.to_pomdp(tmp_path / "large.pomdp")
    assert not list(tmp_path.iterdir())
