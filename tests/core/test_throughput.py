"""The study of throughput: speeds in ticks, pairing, and what holds a purity."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import beltsort
from beltsort import ArgumentError, evaluate_moving
from beltsort.planning.named_moving_policy import named_moving_policy
from beltsort.planning.throughput import ArmTimes, Throughput, throughput
from beltsort.planning.throughput.figure import draw_throughput
from beltsort.planning.throughput.table import throughput_table

MODEL = beltsort.models.paper()
WORDS = ["moving-search:1", "most-urgent:0.95", "stop-and-go:threshold:0.94"]
TIMES = ArmTimes(move=0.5, scan=0.5, tick=0.5)


@pytest.fixture(scope="module")
def found() -> Throughput:
    return throughput(MODEL, WORDS, [10, 40], TIMES, objects=20, runs=12, seed=5)


def test_times_of_the_arm_are_rounded_up_and_those_of_the_belt_to_the_nearest_tick() -> None:
    belt = ArmTimes(move=0.51, scan=0.25, sort=0.1, tick=0.25).belt(MODEL, 31, reach=1)
    assert (belt.look_ticks.max(), belt.decision_ticks, belt.ticks_per_place) == (3 + 1, 1, 8)
    assert ArmTimes(move=0.3, scan=0.0, tick=0.1).belt(MODEL, 60).look_ticks.max() == 3
    moves = ((0.0, 0.3, 0.6), (0.3, 0.0, 0.31), (0.6, 0.31, 0.0))
    ticks = ArmTimes(move=moves, scan=0.3, tick=0.3).belt(MODEL, 10).look_ticks
    assert ticks.tolist() == [[1, 2, 3], [2, 1, 3], [3, 3, 1]]


def test_every_speed_and_policy_has_what_its_simulation_says(found: Throughput) -> None:
    assert [(result.ticks_per_place, result.policy) for result in found.results] == [
        (ticks, word) for ticks in (12, 3) for word in WORDS
    ]
    result = found.of("most-urgent:0.95")[1]
    belt, policy = named_moving_policy("most-urgent:0.95", TIMES.belt(MODEL, 40))
    alone = evaluate_moving(belt, policy, objects=20, runs=12, seed=5)
    assert result.statistics == alone.statistics()
    first = found.of(WORDS[0])[1].statistics.reward_per_object.value
    own = result.statistics.reward_per_object.value
    assert result.reward_difference.mean == pytest.approx(own - first)
    assert found.of(WORDS[0])[0].reward_difference.mean == 0


def test_only_searches_are_timed(found: Throughput) -> None:
    timed = {result.policy for result in found.results if result.plan_seconds is not None}
    assert timed == {"moving-search:1"}


def test_a_faster_belt_misses_more_and_one_that_stands_none(found: Throughput) -> None:
    slow, fast = (result.statistics.missed.value for result in found.of("most-urgent:0.95"))
    assert slow < fast
    assert all(result.statistics.missed.value == 0 for result in found.of(WORDS[2]))


def test_what_holds_a_purity_is_the_most_objects_per_minute_that_do(found: Throughput) -> None:
    easy = Throughput(found.results, TIMES, 0.01, 20, 12, 5)
    for held in easy.held():
        assert held.result == found.of(held.policy)[1], "the faster one"
    hard = Throughput(found.results, TIMES, 1.0, 20, 12, 5)
    for held in hard.held():
        assert held.result is None or held.result.statistics.least_purity.value == 1.0
    assert "at none of these speeds" in throughput_table(hard)


def test_a_purity_just_below_the_estimate_is_held_but_not_by_the_interval(found: Throughput) -> None:
    policy = "most-urgent:0.95"
    result = found.of(policy)[1]
    least = result.statistics.least_purity
    assert least.standard_error > 0
    for below, by_interval, said in ((0.1, False, "does not hold it"), (2.1, True, "holds it too")):
        alone = Throughput((result,), TIMES, least.value - below * least.standard_error, 20, 12, 5)
        assert [(held.result, held.by_interval) for held in alone.held()] == [(result, by_interval)]
        assert alone.to_dict()["held"][policy]["by_interval"] is by_interval
        assert throughput_table(alone).endswith(f"whose lower end {said}")


def test_the_table_and_the_figure_show_every_policy(found: Throughput, tmp_path: Path) -> None:
    table = throughput_table(found)
    assert all(table.count(word) >= 3 for word in WORDS)
    draw_throughput(found, tmp_path / "figure.svg")
    assert (tmp_path / "figure.svg").stat().st_size > 1000


def test_numbers_are_plain_data(found: Throughput) -> None:
    plain = found.to_dict()
    assert len(plain["results"]) == len(found.results)
    assert set(plain["held"]) == set(WORDS)
    shares = [result["right"]["value"] + result["wrong"]["value"] + result["missed"]["value"]
              for result in plain["results"]]  # fmt: skip
    np.testing.assert_allclose(shares, 1)


def test_a_single_run_has_no_standard_errors() -> None:
    plain = throughput(MODEL, WORDS[1:], [10], TIMES, objects=3, runs=1).to_dict()
    json.dumps(plain, allow_nan=False)
    assert plain["results"][1]["reward_difference"]["standard_error"] is None


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"policies": []}, "policies"),
        ({"policies": ["most-urgent:0.9"] * 2}, "each once"),
        ({"speeds": []}, "speeds"),
        ({"speeds": [0.0]}, "0 places per minute"),
        ({"speeds": [1000.0]}, "shorter tick"),
        ({"purity": 1.5}, "purity = 1.5"),
        ({"runs": 0}, "runs = 0"),
    ],
)
def test_a_study_that_makes_no_sense_is_refused(changes: dict[str, object], named: str) -> None:
    settings = {"policies": ["most-urgent:0.9"], "speeds": [10.0], "times": TIMES, "runs": 1, "objects": 2}
    with pytest.raises(ArgumentError, match=named):
        throughput(MODEL, **{**settings, **changes})  # type: ignore[arg-type]  # the mistakes


@pytest.mark.parametrize(
    "times", [{"tick": 0.0}, {"move": -1.0}, {"move": ((-1.0,),)}, {"scan": float("nan")}]
)
def test_times_that_make_no_sense_are_refused(times: dict[str, Any]) -> None:
    with pytest.raises(ArgumentError, match="seconds"):
        ArmTimes(**times)
