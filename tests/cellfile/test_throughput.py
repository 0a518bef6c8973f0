"""The study of throughput of a simulated cell: belts sorted from depth scans, and what is counted of them."""

from pathlib import Path

import numpy as np
import pytest

import beltsort
from beltsort import ArgumentError, SortingModel
from beltsort.cellfile.description import CellDescription
from beltsort.cellfile.ingredients import model_and_classifier
from beltsort.cellfile.moving_run import open_moving_run
from beltsort.cellfile.problems import CellFileError
from beltsort.cellfile.sorted_belt import SimulatedBelt, SortedBelt, sort_belt
from beltsort.cellfile.throughput import SortedBelts, cell_throughput
from beltsort.perception import Classifier
from beltsort.planning.throughput.table import throughput_table
from tests.cellfile.test_moving import DRY_RUN, EXAMPLE, changed

FASTER = (("exposure = 0.03", "exposure = 0.0"), ("ticks_per_place = 12", "ticks_per_place = 6"))
OBJECTS, SEED = 4, 7
MOVING, STANDING = "most-urgent:0.8", "stop-and-go:threshold:0.9"


@pytest.fixture(scope="module")
def cell(tmp_path_factory: pytest.TempPathFactory) -> CellDescription:
    return CellDescription.load(changed(tmp_path_factory.mktemp("cell"), *FASTER))


@pytest.fixture(scope="module")
def prepared(cell: CellDescription) -> tuple[SortingModel, Classifier]:
    return model_and_classifier(cell, None, None)


@pytest.fixture(scope="module")
def moving(cell: CellDescription, prepared: tuple[SortingModel, Classifier]) -> SortedBelt:
    return sort_belt(SimulatedBelt(cell, MOVING, OBJECTS, SEED, *prepared))


@pytest.fixture(scope="module")
def standing(cell: CellDescription, prepared: tuple[SortingModel, Classifier]) -> SortedBelt:
    return sort_belt(SimulatedBelt(cell, STANDING, OBJECTS, SEED, *prepared))


def test_a_moving_belt_is_sorted_as_by_a_run(moving: SortedBelt, tmp_path: Path) -> None:
    edits = (("objects = 20", f"objects = {OBJECTS}"), ("seed = 0", f"seed = {SEED}"))
    planner = ("trials = 10", f'policy = "{MOVING}"')
    cell = CellDescription.load(changed(tmp_path, *FASTER, *edits, planner))
    run = open_moving_run(cell, tmp_path, live=False, say=print)
    report = run.sort()
    np.testing.assert_array_equal(moving.confusion, report.confusion)
    assert moving.confusion.sum() + moving.missed.sum() == OBJECTS
    assert moving.missed.sum() == OBJECTS - sum(report.bins)
    assert moving.seconds == pytest.approx(OBJECTS * 3.0)
    assert moving.looks >= moving.confusion.sum()
    assert moving.plan_seconds == ()


def test_with_stop_and_go_the_belt_waits_for_every_object(
    cell: CellDescription, standing: SortedBelt
) -> None:
    assert standing.confusion.sum() == OBJECTS
    assert standing.missed.sum() == 0
    assert cell.moving is not None
    advances = OBJECTS * 6 * cell.moving.seconds_per_tick
    looks = standing.looks / cell.belt.positions * cell.moving.seconds_per_tick
    assert standing.seconds > advances + looks
    assert standing.motion_cost >= OBJECTS


def test_plans_of_a_search_are_timed(
    cell: CellDescription, prepared: tuple[SortingModel, Classifier]
) -> None:
    found = sort_belt(SimulatedBelt(cell, "moving-search:1", 1, SEED, *prepared))
    assert all(seconds > 0 for seconds in found.plan_seconds)
    assert found.plan_seconds


def test_rewards_are_those_of_the_objects_and_moves() -> None:
    model = beltsort.models.paper()
    belt = beltsort.MovingBelt(model, ticks_per_place=4, missed=[1, 2, 3, 4], seconds_per_tick=0.5)
    confusion, missed = np.zeros((4, 4), dtype=np.uint64), np.array([0, 1, 0, 2], dtype=np.uint64)
    confusion[1, 1], confusion[2, 0] = 3, 1
    one = SortedBelt(confusion, missed, 9, 5.0, 30.0, ())
    other = SortedBelt(0 * confusion, 0 * missed, 0, 0.0, 0.0, ())
    runs = SortedBelts(belt, [one, other])
    assert runs.right.tolist() == [3, 0]
    assert runs.wrong.tolist() == [1, 0]
    assert runs.objects.tolist() == [7, 1]
    assert runs.ticks.tolist() == [60, 0]
    assert runs.returns.tolist() == [3 * model.r_max - model.r_min - (2 + 2 * 4) - 5.0, 0.0]


def test_the_study_has_a_row_for_every_speed_and_policy(cell: CellDescription, standing: SortedBelt) -> None:
    done: list[tuple[int, int]] = []
    found = cell_throughput(
        *(cell, [MOVING, STANDING], [10, 20]),
        objects=OBJECTS,
        runs=1,
        seed=SEED,
        workers=1,
        progress=lambda *counts: done.append(counts),
    )
    assert done[-1] == (4, 4)
    rows = [(row.policy, row.ticks_per_place, row.places_per_minute) for row in found.results]
    assert rows == [(name, *speed) for speed in ((12, 10.0), (6, 20.0)) for name in (MOVING, STANDING)]
    for row in found.results:
        shares = row.statistics
        assert shares.right.value + shares.wrong.value + shares.missed.value == pytest.approx(1)
        assert shares.discounted_return is None
    last = found.results[-1].statistics.objects_per_minute
    assert last is not None
    assert last.value == pytest.approx(60 * OBJECTS / standing.seconds)
    assert found.to_dict()["seconds"]["move"] == ((0.0, 2.0, 2.0), (2.0, 0.0, 2.0), (2.0, 2.0, 0.0))
    assert throughput_table(found).count(STANDING) == 3


def test_a_cell_that_cannot_be_simulated_is_refused(tmp_path: Path) -> None:
    standing = CellDescription.load(EXAMPLE.with_name("simulated.toml"))
    with pytest.raises(CellFileError, match=r"^moving: is missing.*docs/moving\.md"):
        cell_throughput(standing, [MOVING], [10])
    elsewhere = CellDescription.load(changed(tmp_path, *DRY_RUN))
    with pytest.raises(CellFileError, match="arm, camera, belt is not simulated, expected all"):
        cell_throughput(elsewhere, [MOVING], [10])


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"objects": 0}, "objects is 0"),
        ({"runs": 0}, "runs is 0"),
        ({"speeds": [1000]}, "shorter tick"),
        ({"policies": ["most"]}, "most-urgent"),
        ({"purity": 0.0}, r"purity = 0\.0"),
    ],
)
def test_a_study_that_makes_no_sense_is_refused(
    cell: CellDescription, changes: dict[str, object], named: str
) -> None:
    settings: dict[str, object] = {"policies": [MOVING], "speeds": [10.0]}
    with pytest.raises(ArgumentError, match=named):
        cell_throughput(cell, **{**settings, **changes})  # type: ignore[arg-type]  # the mistakes
