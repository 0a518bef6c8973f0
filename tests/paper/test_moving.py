"""The study of throughput as an experiment: its rows, what holds a purity, and claims."""

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from beltsort.models import paper
from beltsort.paper import FULL, QUICK, moving_figure, moving_points, moving_table, sort_moving
from beltsort.paper.files import _read_csv, _typed, write_csv
from beltsort.paper.moving import MISSED, POLICIES, fastest_pure, held_table, moving_claims
from beltsort.planning.throughput import OBJECTS, ArmTimes, throughput

SPEEDS = (10.0, 60.0)
MOVING, STANDING = "most-urgent:0.9", "stop-and-go:threshold:0.9"


def row(policy: str, rate: float, purity: float | None, speed: float = 20.0) -> dict[str, Any]:
    """A row of the table, with a purity that is known to 0.005."""
    return {
        "policy": policy, "places_per_minute": speed, "ticks_per_place": 6, "batches": 40, "objects": 50,
        "objects_per_minute": rate, "objects_per_minute_standard_error": 0.1,
        "missed": 0.125, "least_purity": purity, "least_purity_standard_error": 0.005,
    }  # fmt: skip


@pytest.fixture(scope="module")
def table() -> list[dict[str, Any]]:
    points = moving_points(replace(QUICK, speeds=SPEEDS, runs_moving=2), seed=4)
    return moving_table([point | sort_moving(point) for point in points])


def test_rows_are_those_of_the_study_of_throughput(table: list[dict[str, Any]]) -> None:
    seed = moving_points(QUICK, seed=4)[0]["seed"]
    found = throughput(
        paper(), POLICIES[1:4], SPEEDS, ArmTimes(), missed=MISSED, objects=OBJECTS, runs=2, seed=seed
    )
    assert [(r["policy"], r["ticks_per_place"]) for r in table] == [(p, t) for t in (12, 2) for p in POLICIES]
    for result in found.results:
        (own,) = [
            r for r in table if (r["policy"], r["ticks_per_place"]) == (result.policy, result.ticks_per_place)
        ]
        assert own["right"] == result.statistics.right.value
        assert own["missed_standard_error"] == result.statistics.missed.standard_error
    assert "plan_seconds" not in table[0], "it depends on the machine"


def test_where_nothing_is_decided_there_is_no_purity(table: list[dict[str, Any]], tmp_path: Path) -> None:
    (nothing,) = [r for r in table if r["least_purity"] is None]
    assert (nothing["policy"], nothing["missed"]) == ("most-urgent:0.99", 1.0)
    again = [_typed(r) for r in _read_csv(write_csv(tmp_path / "moving.csv", table))]
    assert math.isnan(again[table.index(nothing)]["least_purity_standard_error"])
    assert fastest_pure([nothing]) is None
    assert held_table([nothing])[0]["held by the estimate"] == "at none of these speeds"
    assert len(moving_figure(again).axes) == 2


def test_the_quick_run_is_a_part_of_the_full_one() -> None:
    full, quick = (moving_points(design, seed=0) for design in (FULL, QUICK))
    assert {point["speed"] for point in quick} < {point["speed"] for point in full}
    assert quick[0]["runs"] < full[0]["runs"]
    assert moving_points(replace(QUICK, speeds=()), seed=0) == []


def test_what_is_held_by_the_estimate_need_not_be_by_the_interval() -> None:
    rows = [
        row(MOVING, 18.0, 0.94),
        row(MOVING, 17.0, 0.955),
        row(MOVING, 14.0, 0.97),
        row(STANDING, 16.0, 0.98),
    ]
    assert fastest_pure(rows) == rows[1]
    assert fastest_pure(rows, by_interval=True) == rows[3]
    assert fastest_pure(rows[:3], by_interval=True) == rows[2]
    by_estimate, by_interval = moving_claims(rows)
    assert (by_estimate.estimate.value, str(by_estimate.conclusion)) == (1.0, "holds")
    assert (by_interval.estimate.value, str(by_interval.conclusion)) == (-2.0, "fails")
    assert by_estimate.estimate.standard_error == pytest.approx(math.hypot(0.1, 0.1))
    assert "12.5 % of the objects are missed" in by_estimate.text


def test_nothing_is_claimed_where_one_side_never_holds_the_purity() -> None:
    assert moving_claims([row(MOVING, 18.0, 0.9), row(STANDING, 16.0, 0.98)]) == []
    assert moving_claims([]) == []
