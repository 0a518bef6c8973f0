"""A cell whose belt lies anywhere in the robot's world, and whose camera sits anywhere on the flange."""

import dataclasses
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from beltsort.cell import Cell, Scan
from beltsort.cell.arrival import Deviation, deviation
from beltsort.cell.frames import from_quaternion
from beltsort.cell.placement import Placement
from beltsort.cellfile.check import check_cell
from beltsort.cellfile.composed import ComposedCell
from beltsort.cellfile.description import CellDescription
from beltsort.cellfile.registry import BUILT_IN, Backend
from beltsort.cellfile.sections import CheckLimits
from beltsort.geometry import Pose, transform
from beltsort.perception import NearestNeighbour, Perception
from beltsort.sim import CellConfig, SimulatedCell
from beltsort.sim.collect import collect_training
from beltsort.sim.rotations import rotation
from tests.cellfile.cell_files import EXAMPLE, composed, described

pytestmark = pytest.mark.slow

WORLD_FROM_BELT = from_quaternion((0.55, -0.2, 0.12), (0.1, -0.5, 0.5, 0.7))
FLANGE_FROM_CAMERA = from_quaternion((0.02, 0.05, 0.03), (0.5, -0.5, 0.1, 0.7))
TRUE_LABELS = [0, 1, 2, 3]
LIMITS = CheckLimits(belt_angle=2.0, belt_height=25.0, crop_inside=0.5)


class BlindCell(SimulatedCell):
    """Its camera does not tell its pose; the arm tells the flange's."""

    def scan(self, *, not_before: float, **timeout: float) -> Scan:
        scan = super().scan(not_before=not_before, **timeout)
        return dataclasses.replace(scan, world_from_camera=np.full((4, 4), np.nan))


def backend(kind: Callable[..., SimulatedCell]) -> Backend:
    """Return cells that stand as this module says, whatever the file says."""
    truth = Placement(WORLD_FROM_BELT, FLANGE_FROM_CAMERA)
    return Backend(
        lambda _options, _cell: kind(TRUE_LABELS, CellConfig(), 5, truth), shared=True, harmless=True
    )


TELLING, BLIND = backend(SimulatedCell), backend(BlindCell)


def rows(pose: Pose) -> str:
    return f"{{matrix = {pose.tolist()}}}"


def placed(
    folder: Path,
    patch: pytest.MonkeyPatch,
    name: str,
    *,
    belt: Pose = WORLD_FROM_BELT,
    hand_eye: Pose = FLANGE_FROM_CAMERA,
) -> ComposedCell:
    """Return the example's cell, its devices as this module says and its file as the arguments say."""
    patch.setitem(BUILT_IN, name.lower(), dict.fromkeys(BUILT_IN["simulated"], f"{__name__}:{name}"))
    backends = f'backend = "{name.lower()}"'
    return composed(
        folder,
        ('backend = "simulated"', backends),
        ('[backends.simulated]\ndraw_from = ["elongated", "livarno"]\nseed = 0\n', ""),
        (f"[camera]\n{backends}\n", f"[camera]\n{backends}\nflange_from_camera = {rows(hand_eye)}\n"),
        ("positions = 2", f"positions = 2\nworld_from_belt = {rows(belt)}"),
    )


def scans_of(cell: Cell) -> list[Scan]:
    """Return a scan from each viewpoint."""
    return [
        cell.camera.scan(not_before=cell.arm.move_to(viewpoint, f"move-{viewpoint}"))
        for viewpoint in range(len(cell.viewpoints))
    ]


@pytest.fixture(scope="module")
def perception() -> Perception:
    database: NearestNeighbour = collect_training(CellConfig(), objects=1, seed=3, workers=1)
    return Perception(CellConfig().layout, database)


@pytest.mark.parametrize("name", ["TELLING", "BLIND"])
def test_where_belt_and_camera_are_changes_no_label(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, perception: Perception, name: str
) -> None:
    here = scans_of(SimulatedCell(TRUE_LABELS, CellConfig(), seed=5))
    there = scans_of(placed(tmp_path, monkeypatch, name))
    for before, after in zip(here, there, strict=True):
        np.testing.assert_allclose(after.world_from_camera, before.world_from_camera, atol=1e-12)
        np.testing.assert_array_equal(after.points, before.points)
        assert not after.assumed
        labels = [seen.label for seen in perception(after)]
        assert labels == [seen.label for seen in perception(before)]
        assert None not in labels


def test_a_simulated_cell_stands_where_its_file_says(tmp_path: Path) -> None:
    table = f"positions = 2\nworld_from_belt = {rows(WORLD_FROM_BELT)}"
    made: list[SimulatedCell] = []
    cell = composed(tmp_path, ("positions = 2", table), made=made.append)
    viewpoint = CellConfig().viewpoints[0].pose()
    told, known = made[0].scan(not_before=0.0), cell.camera.scan(not_before=0.0)
    np.testing.assert_allclose(told.world_from_camera, WORLD_FROM_BELT @ viewpoint, atol=1e-12)
    np.testing.assert_allclose(known.world_from_camera, viewpoint, atol=1e-12)


def test_without_a_hand_eye_transform_the_viewpoint_is_taken(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(BUILT_IN, "blind", dict.fromkeys(BUILT_IN["simulated"], f"{__name__}:BLIND"))
    seed = ('[backends.simulated]\ndraw_from = ["elongated", "livarno"]\nseed = 0\n', "")
    cell = composed(tmp_path, ('backend = "simulated"', 'backend = "blind"'), seed)
    (first, *_), expected = scans_of(cell), described(tmp_path).viewpoints[0].pose()
    np.testing.assert_array_equal(first.world_from_camera, expected)
    assert first.assumed
    assert [view.pose for view in check_cell(cell, LIMITS).views] == [None] * 3


@pytest.mark.parametrize("name", ["TELLING", "BLIND"])
def test_a_cell_that_stands_as_its_file_says_passes_the_check(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    found = check_cell(placed(tmp_path, monkeypatch, name), LIMITS)
    assert found.exceeded == []
    assert all(view.pose and not view.pose.exceeds(1e-5, 1e-6) for view in found.views)


def off_by(degrees: float = 0.0, metres: float = 0.0, axis: int = 0) -> Pose:
    """Return a small transform about or along an axis."""
    error = np.eye(4)
    error[:3, :3] = rotation(np.radians(degrees) * np.eye(3)[axis])
    error[axis, 3] = metres
    return error


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("error", [{"degrees": 2.0}, {"metres": 0.02}])
def test_a_wrong_hand_eye_transform_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: dict[str, float], axis: int
) -> None:
    wrong = FLANGE_FROM_CAMERA @ off_by(**error, axis=axis)
    found = check_cell(placed(tmp_path, monkeypatch, "BLIND", hand_eye=wrong), LIMITS)
    told = [line for line in found.exceeded if "(check.pose_angle)" in line and "hand-eye" in line]
    assert [line.split(":")[0] for line in told] == ["p1", "p2", "p3"]


def test_a_wrong_place_of_the_belt_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    wrong = WORLD_FROM_BELT @ off_by(metres=0.02)
    found = check_cell(placed(tmp_path, monkeypatch, "TELLING", belt=wrong), LIMITS)
    (first, *_) = found.exceeded
    assert re.match(r"p1: .*\b0\.00 degrees\b.*\b20\.0 mm\b.*\(check\.pose_distance\)", first)


def test_where_nothing_moves_no_pose_is_expected(tmp_path: Path) -> None:
    arm = ('[arm]\nbackend = "simulated"', '[arm]\nbackend = "dry-run"')
    assert composed(tmp_path, arm).poses == (None,) * 3


def test_an_arm_is_sent_where_its_camera_sees_what_the_viewpoint_sees() -> None:
    placement, viewpoint = Placement(WORLD_FROM_BELT, FLANGE_FROM_CAMERA), CellConfig().viewpoints[1].pose()
    flange = placement.of_flange(viewpoint)
    assert flange is not None
    there = placement.of_camera(flange)
    assert there is not None
    np.testing.assert_allclose(there, viewpoint, atol=1e-12)
    ahead = transform(WORLD_FROM_BELT, np.zeros(3)) - (flange @ FLANGE_FROM_CAMERA)[:3, 3]
    forward = (flange @ FLANGE_FROM_CAMERA)[:3, 2]
    np.testing.assert_allclose(ahead / np.linalg.norm(ahead), forward, atol=1e-12)


@pytest.mark.parametrize(
    ("error", "expected"),
    [({"degrees": 3.0}, Deviation(3.0, 0.0)), ({"metres": -0.004}, Deviation(0.0, 4.0))],
)
def test_the_difference_of_two_poses(error: dict[str, Any], expected: Deviation) -> None:
    found = deviation(WORLD_FROM_BELT @ off_by(**error, axis=1), WORLD_FROM_BELT)
    assert found.angle == pytest.approx(expected.angle, abs=1e-5)
    assert found.distance == pytest.approx(expected.distance, abs=1e-9)


def test_the_file_tells_the_placement() -> None:
    placement = CellDescription.load(EXAMPLE).placement
    assert placement.world_from_belt is None
    assert placement.of_camera(np.eye(4)) is placement.of_flange(np.eye(4)) is None
