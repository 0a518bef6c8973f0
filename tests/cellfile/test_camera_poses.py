"""Cameras that do not know where they stand."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from beltsort.cell import CommandError, Scan
from beltsort.cellfile.composed import ComposedCell
from beltsort.cellfile.dry_run import EmptyBeltCamera
from beltsort.cellfile.registry import BUILT_IN, Backend
from beltsort.errors import CellError
from tests.cellfile.cell_files import composed, described

CAMERA = ('[camera]\nbackend = "simulated"', '[camera]\nbackend = "lost"')


class LostCamera(EmptyBeltCamera):
    """Does not know its pose."""

    def scan(self, *, not_before: float, **timeout: float) -> Scan:
        scan = super().scan(not_before=not_before, **timeout)
        return dataclasses.replace(scan, world_from_camera=np.full((4, 4), np.nan))


LOST = Backend(lambda options, cell: LostCamera(np.eye(4)), harmless=True)


@pytest.fixture
def lost(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> ComposedCell:
    """Return a cell with such a camera, whose second move fails and whose third viewpoint has no pose."""
    monkeypatch.setitem(BUILT_IN, "lost", {"camera": f"{__name__}:LOST"})
    fault = '[faults]\nschedule = [{command = "move_to", number = 2, kind = "not_done"}]\n[planner]'
    joints = ("azimuth = -120.0\nelevation = 70.0", "joints = [0.1, 0.2]")
    arm = ('[arm]\nbackend = "simulated"', '[arm]\nbackend = "dry-run"')
    return composed(tmp_path, CAMERA, ("[planner]", fault), joints, arm, *OTHERS)


OTHERS = (
    ('[belt]\nbackend = "simulated"', '[belt]\nbackend = "dry-run"'),
    ('[sorter]\nbackend = "simulated"', '[sorter]\nbackend = "dry-run"'),
    ('[backends.simulated]\ndraw_from = ["elongated", "livarno"]\nseed = 0\n', ""),
)


def test_they_stand_where_the_arm_arrived(lost: ComposedCell, tmp_path: Path) -> None:
    stop = lost.arm.move_to(1, "move-1")
    pose = lost.camera.scan(not_before=stop).world_from_camera
    np.testing.assert_array_equal(pose, described(tmp_path).viewpoints[1].pose())


def test_after_a_failed_move_nobody_knows_where_that_is(lost: ComposedCell) -> None:
    lost.arm.move_to(1, "move-1")
    with pytest.raises(CommandError):
        lost.arm.move_to(0, "move-2")
    with pytest.raises(CellError, match=r"\bcamera\b.*\bpose\b.*\barm\b.*\bviewpoint\b"):
        lost.camera.scan(not_before=0.0)


def test_a_viewpoint_without_a_pose_is_named(lost: ComposedCell) -> None:
    lost.arm.move_to(2, "move-1")
    with pytest.raises(CellError, match=r"\bcamera\b.*viewpoint p3\b.*\bjoint\b"):
        lost.camera.scan(not_before=0.0)


def test_a_camera_that_knows_its_pose_keeps_it(tmp_path: Path) -> None:
    cell = composed(tmp_path)
    scan = cell.camera.scan(not_before=0.0)
    np.testing.assert_array_equal(scan.world_from_camera, described(tmp_path).viewpoints[0].pose())
