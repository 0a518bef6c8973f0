"""The check of a cell against its limits."""

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from beltsort.cell import CommandError, Health, Outcome, Scan
from beltsort.cell.wrappers.recorder import Recorded
from beltsort.cellfile.check import check_cell
from beltsort.cellfile.sections import CheckLimits
from tests.cellfile.cell_files import composed, described

FAULTS = "[faults]\nschedule = [{{command = {command}, number = {number}, kind = {kind}}}]\n[planner]"


def fault(command: str, number: int, kind: str) -> tuple[str, str]:
    return "[planner]", FAULTS.format(command=f'"{command}"', number=number, kind=f'"{kind}"')


def test_the_example_is_within_its_limits(tmp_path: Path) -> None:
    calls: list[Recorded] = []
    found = check_cell(composed(tmp_path, record=calls.append), described(tmp_path).check)
    assert found.exceeded == []
    assert [view.viewpoint for view in found.views] == ["p1", "p2", "p3"]
    assert all(view.pose_fault is None for view in found.views)
    assert {len(view.findings) for view in found.views} == {2}
    assert list(found.health) == ["arm", "camera", "belt", "sorter"]
    names = [recorded.call.name for recorded in calls]
    assert (names.count("move_to"), names.count("scan"), names.count("sort")) == (3, 3, 0)


@pytest.mark.parametrize(
    ("limits", "said"),
    [
        ({"belt_angle": 0.01}, r"p1: .*\b0\.01 \(check\.belt_angle\)"),
        ({"belt_height": 0.01}, r"p1: .* mm\b.*\b0\.01 \(check\.belt_height\)"),
        ({"belt_points": 10**6}, r"p1: \d+ points\b.*\b1000000 \(check\.belt_points\)"),
        ({"crop_inside": 1.0}, r"p2, position 2: \d+%.*\b100% \(check\.crop_inside\)"),
        ({"crop_points": 10**6}, r"p1, position 1: \d+ points\b.*\b1000000 \(check\.crop_points\)"),
    ],
)
def test_each_limit_is_kept(tmp_path: Path, limits: dict[str, Any], said: str) -> None:
    lenient = CheckLimits(belt_angle=5.0, belt_height=50.0, belt_points=1, crop_inside=0.1, crop_points=1)
    found = check_cell(composed(tmp_path), lenient.model_copy(update=limits))
    assert found.exceeded
    assert any(re.match(said, line) for line in found.exceeded), found.exceeded


def test_a_camera_whose_pose_is_wrong_is_told_with_the_cause(tmp_path: Path) -> None:
    cell = composed(tmp_path)
    camera = cell.camera

    class Inverted:
        def scan(self, *, not_before: float, timeout: float = 1.0) -> Scan:
            scan = camera.scan(not_before=not_before)
            pose = np.asarray(np.linalg.inv(scan.world_from_camera))
            return replace(scan, world_from_camera=pose)

        def health(self) -> Health:
            return camera.health()

        def stop(self) -> None:
            camera.stop()

    found = check_cell(replace(cell, camera=Inverted()), described(tmp_path).check)
    assert [line.split(":")[0] for line in found.exceeded if "inverted" in line] == ["p1", "p2", "p3"]


def test_the_first_failure_ends_the_visits(tmp_path: Path) -> None:
    cell = composed(tmp_path, fault("move_to", 2, "not_done"))
    found = check_cell(cell, described(tmp_path).check)
    assert [view.viewpoint for view in found.views] == ["p1"]
    (failure,) = found.exceeded
    assert "move_to" in failure


@pytest.mark.slow
def test_bad_scans_are_beyond_the_limits(tmp_path: Path) -> None:
    for kind in ("empty_scan", "nan_scan"):
        found = check_cell(composed(tmp_path, fault("scan", 2, kind)), described(tmp_path).check)
        assert len(found.views) == 3
        assert [line.split(":")[0] for line in found.exceeded] == ["p2", "p2, position 1", "p2, position 2"]
    truncated = check_cell(composed(tmp_path, fault("scan", 3, "truncated_scan")), described(tmp_path).check)
    assert any("(check.crop_inside)" in line for line in truncated.exceeded)


def test_nothing_moves_while_a_device_is_not_ready(tmp_path: Path) -> None:
    calls: list[Recorded] = []
    cell = composed(tmp_path, fault("sort", 1, "emergency_stop"), record=calls.append)
    with pytest.raises(CommandError) as error:
        cell.sorter.sort(0, "sort-1")
    assert error.value.outcome is Outcome.NOT_DONE
    calls.clear()
    found = check_cell(cell, described(tmp_path).check)
    (failure,) = found.exceeded
    assert re.search(r"^arm: .*\bemergency stop\b.*\[faults\]", failure)
    assert {recorded.call.name for recorded in calls} == {"health"}


@pytest.mark.slow
def test_checks_do_not_repeat_each_others_commands(tmp_path: Path) -> None:
    calls: list[Recorded] = []
    cell = composed(tmp_path, record=calls.append)
    for _ in range(2):
        check_cell(cell, described(tmp_path).check)
    ids = [recorded.call.command_id for recorded in calls if recorded.call.name == "move_to"]
    assert len(set(ids)) == 6
