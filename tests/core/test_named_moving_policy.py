"""Policies for moving belts by name, stop-and-go among them."""

from pathlib import Path

import numpy as np
import pytest

import beltsort
from beltsort import ArgumentError, MovingBelt, MovingPlanner, MovingThreshold, evaluate_moving
from beltsort.planning.named_moving_policy import named_moving_policy
from beltsort.planning.stop_and_go import stop_and_go_belt


@pytest.fixture(scope="module")
def belt() -> MovingBelt:
    return MovingBelt(
        beltsort.models.paper(),
        ticks_per_place=4,
        reach=2,
        sort_ticks=1,
        move_ticks=2 - np.eye(3),
        seconds_per_tick=0.5,
    )


@pytest.mark.parametrize(
    ("text", "settings"),
    [
        ("most-urgent:0.9", {"high": 0.9, "low": 0.9, "rule": "most-urgent"}),
        ("falling-threshold:0.9:0.6", {"high": 0.9, "low": 0.6, "rule": "most-urgent"}),
        ("information-per-tick:0.8", {"high": 0.8, "low": 0.8, "rule": "information-per-tick"}),
    ],
)
def test_a_word_makes_a_threshold(belt: MovingBelt, text: str, settings: dict[str, float | str]) -> None:
    own_belt, policy = named_moving_policy(text, belt)
    assert own_belt is belt
    assert isinstance(policy, MovingThreshold)
    assert policy.settings == settings


def test_a_word_makes_a_search_with_its_trials(belt: MovingBelt) -> None:
    _, policy = named_moving_policy("moving-search:7", belt)
    assert isinstance(policy, MovingPlanner)
    assert policy.settings["trials"] == 7


def test_stop_and_go_earns_what_the_model_alone_does_and_takes_the_ticks_of_looks_and_advances(
    belt: MovingBelt,
) -> None:
    standing, policy = named_moving_policy("stop-and-go:threshold:0.9", belt)
    assert standing == stop_and_go_belt(belt)
    assert (standing.advance_ticks, standing.look_ticks.tolist()) == (4, belt.look_ticks.tolist())
    moving = evaluate_moving(standing, policy, objects=10, runs=30, seed=4)
    threshold = beltsort.Threshold(belt.model, 0.9)
    today = beltsort.evaluate(belt.model, threshold, batches=30, batch_size=10, seed=4)
    np.testing.assert_array_equal(moving.right, today.correct)
    np.testing.assert_allclose(moving.returns, today.returns)
    # One viewpoint is looked from: the first look moves there, in two ticks, and all others take one.
    np.testing.assert_array_equal(moving.ticks, today.steps - 10 + 1 + 10 * 4)
    assert moving.missed.sum() == 0


def test_an_object_of_ones_own_is_called_with_the_belt(
    belt: MovingBelt, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "mine_moving.py").write_text(
        "import beltsort\n\n\ndef idle(belt):\n    return beltsort.MovingThreshold(belt, 0.5)\n"
    )
    monkeypatch.chdir(tmp_path)
    _, policy = named_moving_policy("mine_moving:idle", belt)
    assert isinstance(policy, MovingThreshold)
    assert policy.belt == belt


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("most-urgend:0.9", "most-urgent"),
        ("falling-threshold:0.9", "not a valid policy"),
        ("most-urgent:often", "often"),
        ("stop-and-go", "there is no policy"),
        ("stop-and-go:treshold:0.9", "threshold"),
    ],
)
def test_words_that_name_no_policy_are_refused(belt: MovingBelt, text: str, named: str) -> None:
    with pytest.raises(ArgumentError, match=named):
        named_moving_policy(text, belt)


def test_a_belt_that_stands_already_is_refused() -> None:
    with pytest.raises(ArgumentError, match="neither of ticks_per_place"):
        stop_and_go_belt(MovingBelt(beltsort.models.paper(), advance_ticks=1))
