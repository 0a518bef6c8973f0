"""Cell files with [moving]: a belt that never stops."""

from pathlib import Path

import numpy as np
import pytest

import beltsort
from beltsort.cell import BeltReading, Diversion, DivertingCell, MoveTo
from beltsort.cell.wrappers.recorder import Recorded
from beltsort.cellfile.composed import compose
from beltsort.cellfile.composed_moving import ComposedMovingCell, compose_moving
from beltsort.cellfile.description import CellDescription
from beltsort.cellfile.following_cell import FollowingCell
from beltsort.cellfile.ingredients import moving_policy_of
from beltsort.cellfile.moving import moving_policy
from beltsort.cellfile.problems import CellFileError
from beltsort.sim import BeltDrive, MovingCell
from beltsort.sorting.command import Command
from tests.cellfile import cell_files

EXAMPLE = Path(__file__).parents[2] / "beltsort" / "cellfile" / "examples" / "moving.toml"
BELT = '[belt]\nbackend = "simulated"'
DRY_RUN = (('"simulated"', '"dry-run"'), ("[backends.simulated]\nseed = 0\n", ""))
"""Changes after which no device of the example is there."""


def changed(folder: Path, *changes: tuple[str, str]) -> Path:
    """Write the example with pieces of its text replaced, and return its path."""
    return cell_files.changed(folder, *changes, example=EXAMPLE)


def composed(path: Path, calls: list[Recorded] | None = None) -> ComposedMovingCell:
    record = None if calls is None else calls.append
    return compose_moving(CellDescription.load(path), live=False, say=print, record=record)


def test_the_example_gives_the_belt_that_is_planned_for(tmp_path: Path) -> None:
    description = CellDescription.load(EXAMPLE)
    assert description.moving is not None
    assert description.moving.speed(description.belt.spacing) == pytest.approx(0.03)
    belt = description.moving.belt(beltsort.models.paper())
    assert (belt.ticks_per_place, belt.reach, belt.seconds_per_tick) == (12, 2, 0.5)
    policy = moving_policy(description.planner, belt, tmp_path)
    assert isinstance(policy.act(belt.belief(), 0), beltsort.Move)
    timed = CellDescription.load(changed(tmp_path, ("trials = 10", "seconds = 0.001\nscenarios = 50")))
    assert isinstance(moving_policy(timed.planner, belt, tmp_path), beltsort.MovingPlanner)
    named = CellDescription.load(changed(tmp_path, ("trials = 10", 'policy = "most-urgent:0.9"')))
    policy, name = moving_policy_of(named, belt, None)
    assert (repr(policy), name) == (repr(beltsort.MovingThreshold(belt, 0.9)), "most-urgent:0.9")
    standing = CellDescription.load(changed(tmp_path, ("trials = 10", 'policy = "stop-and-go:one-object"')))
    with pytest.raises(CellFileError, match=r"^planner\.policy: .*stands while the arm looks"):
        moving_policy_of(standing, belt, None)


def test_prices_are_by_class(tmp_path: Path) -> None:
    prices = "reach = 2\nmissed = { standard = 4, mushroom = 3, livarno = 2, elongated = 1 }"
    description = CellDescription.load(changed(tmp_path, ("reach = 2", prices)))
    assert description.moving is not None
    assert [description.moving.missed[name] for name in description.classes] == [1, 2, 3, 4]
    description.moving.belt(beltsort.models.paper())


WRONG = [
    ("[moving]", '[sorter]\nbackend = "simulated"\n[moving]', r"^sorter: is given.*leave it out"),
    ("objects = 20", "objects = 20\nbelt_ends = true", r"^belt_ends: is true"),
    ("objects = 20", "objects = 20\nreject_bin = 9", r"^reject_bin: is given"),
    ("objects = 20", "objects = 20\ndrift = {}", r"^drift: is given"),
    ("objects = 20", "objects = 20\nrules = {max_looks = 3}", r"^rules\.max_looks: is 3.*empty_looks"),
    ("objects = 20", "objects = 20\nfaults = {seed = 1}", r"^faults: is given"),
    ("reach = 2", "reach = 3", r"^moving\.reach: is 3, expected at most 2"),
    ("[[0, 4, 4], ", "[", r"^moving\.move_ticks: has rows of \[3, 3\] numbers, expected 3 rows of 3"),
    ("reach = 2", "missed = {standrd = 1}", r"^moving\.missed\.standrd: is no class.*'standard'"),
    ("reach = 2", "missed = {standard = 1}", r"^moving\.missed: has no price of \['elongated'"),
    ("ticks_per_place = 12", "", r"^moving\.ticks_per_place: is missing"),
    ("seconds_per_tick = 0.5", "seconds_per_tick = 0", r"^moving\.seconds_per_tick: is 0"),
]


@pytest.mark.parametrize(("old", "new", "told"), WRONG)
def test_a_contradiction_is_told_with_its_key(tmp_path: Path, old: str, new: str, told: str) -> None:
    with pytest.raises(CellFileError, match=told):
        CellDescription.load(changed(tmp_path, (old, new)))


def test_a_back_end_that_cannot_divert_is_told_with_those_that_can(tmp_path: Path) -> None:
    with pytest.raises(CellFileError, match=r"^belt\.backend: is 'ros1', which cannot divert.*simulated"):
        composed(changed(tmp_path, (BELT, '[belt]\nbackend = "ros1"')))


def test_arm_and_camera_are_both_simulated_or_none(tmp_path: Path) -> None:
    others = ('[arm]\nbackend = "simulated"', '[arm]\nbackend = "dry-run"')
    with pytest.raises(CellFileError, match="arm is not simulated"):
        composed(changed(tmp_path, others))


def test_simulated_objects_follow_another_belt_in_real_time(tmp_path: Path) -> None:
    cell = composed(changed(tmp_path, (BELT, '[belt]\nbackend = "dry-run"')))
    before = cell.belt.reading()
    stop = cell.arm.move_to(0, "a")
    scan = cell.camera.scan(not_before=stop)
    after = cell.belt.reading()
    assert before.stamp < stop <= scan.stamp < after.stamp
    assert after.travel - before.travel == pytest.approx(0.03 * (after.stamp - before.stamp))
    assert {cell.true_class_at(0.18 * n) for n in range(40)} == {0, 1, 2, 3}


def test_objects_stay_where_they_are_when_the_controller_of_their_belt_is_restarted() -> None:
    cell = FollowingCell([None, 3, 0, None, 2], BeltDrive(belt_speed=0.1))
    cell.follow_belt(BeltReading(stamp=10.0, travel=0.36, boot_id="a"))
    assert cell.true_class_at(0.18) == 3
    assert cell.place(4, time=11.0) == pytest.approx(4 * 0.18 - 0.46)
    cell.follow_belt(BeltReading(stamp=12.0, travel=0.02, boot_id="b"))
    assert cell.place(4, time=12.0) == pytest.approx(4 * 0.18 - 0.56)
    assert cell.true_class_at(4 * 0.18 - 0.54) == 2
    cell.follow_belt(BeltReading(stamp=13.0, travel=0.12, boot_id="b", moving=False))
    assert cell.place(4, time=20.0) == cell.place(4, time=13.0)


def test_a_cell_that_stops_is_not_composed_of_it() -> None:
    with pytest.raises(CellFileError, match=r"^moving: is given"):
        compose(CellDescription.load(EXAMPLE), live=False, say=print)


def test_the_simulated_cell_diverts_moves_and_scans(tmp_path: Path) -> None:
    calls: list[Recorded] = []
    cell: DivertingCell = composed(changed(tmp_path), calls)
    reading = cell.belt.reading()
    queued = cell.belt.divert("a", number=0, coordinate=0.18, label=3, boot_id=reading.boot_id)
    assert queued.state is Diversion.QUEUED
    stop = cell.arm.move_to(1, Command("b", MoveTo(1), "").id)
    assert cell.camera.scan(not_before=stop).stamp >= stop
    cell.wait(60.0)
    assert cell.belt.diversion("a", boot_id=reading.boot_id).state is Diversion.DONE
    moved, passed = cell.belt.reading(), cell.belt.reading().stamp - reading.stamp
    assert moved.travel - reading.travel == pytest.approx(0.03 * passed, abs=1e-6)
    cell.belt.stop()
    cell.wait(1.0)
    assert not cell.belt.reading().moving
    assert cell.belt.reading().travel == moved.travel
    names = [(call.device, call.call.name) for call in calls]
    assert names[:4] == [("belt", "reading"), ("belt", "divert"), ("arm", "move_to"), ("camera", "scan")]


def test_the_belt_gets_the_numbers_of_the_cell_files_bins(tmp_path: Path) -> None:
    bins = "objects = 20\nbins = {elongated = 4, livarno = 5, mushroom = 6, standard = 7}"
    path = changed(tmp_path, *DRY_RUN, ("objects = 20", bins))
    cell = composed(path)
    assert cell.bin_numbers == (4, 5, 6, 7)
    reading = cell.belt.reading()
    told = cell.belt.divert("a", number=0, coordinate=0.2, label=1, boot_id=reading.boot_id)
    assert told.state is Diversion.QUEUED
    assert cell.belt.diversion("a", boot_id=reading.boot_id).state is Diversion.DONE
    assert cell.belt.diversion("b", boot_id=reading.boot_id).state is Diversion.NOT_DONE
    with pytest.raises(beltsort.BeltsortError, match="label is 4"):
        cell.belt.divert("c", number=1, coordinate=0.4, label=4, boot_id=reading.boot_id)


def test_simulated_cups_may_be_empty_and_stand_irregularly(tmp_path: Path) -> None:
    options = ("seed = 0", "seed = 0\nempty = 0.4\npitch_jitter = 0.008")
    made: list[object] = []
    description = CellDescription.load(changed(tmp_path, options))
    cell = compose_moving(description, live=False, say=print, made=made.append)
    (world,) = made
    assert isinstance(world, MovingCell)
    off = [world.place(number, 0.0) - number * 0.18 for number in range(400)]
    assert np.std(off) == pytest.approx(0.008, rel=0.2)
    classes = [cell.true_class_at(number * 0.18) for number in range(400)]
    assert classes.count(None) / 400 == pytest.approx(0.4, abs=0.1)
    assert set(classes) == {None, 0, 1, 2, 3}


@pytest.mark.parametrize(
    ("option", "told"),
    [("empty = 1.5", r"empty: is 1\.5"), ("pitch_jitter = -1", r"pitch_jitter: is -1")],
)
def test_options_of_simulated_cups_are_checked(tmp_path: Path, option: str, told: str) -> None:
    path = changed(tmp_path, ("seed = 0", f"seed = 0\n{option}"))
    with pytest.raises(CellFileError, match=told):
        composed(path)


def test_cups_of_a_belt_that_stops_stand_regularly() -> None:
    cell = CellDescription.load(EXAMPLE.with_name("simulated.toml"))
    jitter = cell.model_copy(update={"backends": {"simulated": {"pitch_jitter": 0.01}}})
    with pytest.raises(CellFileError, match=r"pitch_jitter: is 0\.01, expected 0 for a belt that stops"):
        compose(jitter, live=False, say=print)
