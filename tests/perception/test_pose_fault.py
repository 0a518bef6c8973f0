"""A scan whose pose is wrong does not pass silently."""

import warnings
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from beltsort.geometry import Points, Pose, look_at
from beltsort.perception import PoseCause, PoseFault, PoseWarning, UnitWarning, segment
from beltsort.perception.level import levelled
from beltsort.perception.pose_fault import pose_fault
from beltsort.sim import CellConfig, SimulatedCell, SphereViewpoint
from tests.perception.belt_scene import SyntheticScan

CELL = CellConfig()
LAYOUT = CELL.layout
Y_UP_FROM_Z_UP = np.eye(4)[[0, 2, 1, 3]] * [[1.0], [1.0], [-1.0], [1.0]]
UPSIDE_DOWN = np.diag([1.0, -1.0, -1.0, 1.0])
MIRROR = np.diag([1.0, -1.0, 1.0, 1.0])


def scans(scenes: int, seed: int, empty: float = 0.3) -> Iterator[SyntheticScan]:
    """Yield scans of scenes with empty and full cups, every other one from viewpoints drawn anywhere."""
    rng = np.random.default_rng(seed)
    for scene in range(scenes):
        anywhere = [
            SphereViewpoint(f"p{k}", *rng.uniform((-180.0, 15.0, 0.5), (180.0, 90.0, 0.9))) for k in range(3)
        ]
        config = replace(CELL, viewpoints=tuple(anywhere)) if scene % 2 else CELL
        labels = [None if rng.random() < empty else int(rng.integers(4)) for _ in range(3)]
        cell = SimulatedCell(labels, config, seed=seed + scene)
        for viewpoint in range(3):
            scan = cell.scan(not_before=cell.move_to(viewpoint, f"move-{viewpoint}"))
            yield SyntheticScan(scan.points, scan.world_from_camera)


def lifted(by: float, scan: SyntheticScan) -> SyntheticScan:
    pose = scan.world_from_camera.copy()
    pose[2, 3] += by
    return replace(scan, world_from_camera=pose)


def posed(change: Callable[[Pose], Pose], scan: SyntheticScan) -> SyntheticScan:
    return replace(scan, world_from_camera=change(scan.world_from_camera))


def pointed(change: Callable[[Points], Points], scan: SyntheticScan) -> SyntheticScan:
    return replace(scan, points=change(scan.points))


def scaled(factor: float, pose: Pose) -> Pose:
    return np.hstack([pose[:, :3], pose[:, 3:] * [[factor], [factor], [factor], [1.0]]])


def body(points: Points) -> Points:
    """Return points of an optical frame in a frame with x forward and z up."""
    return np.stack([points[..., 2], -points[..., 0], -points[..., 1]], axis=-1)


def inverse(pose: Pose) -> Pose:
    return np.asarray(np.linalg.inv(pose), dtype=np.float64)


WRONG: dict[str, tuple[Callable[[SyntheticScan], SyntheticScan], PoseCause]] = {
    "40 mm up": (partial(lifted, 0.04), PoseCause.OFFSET),
    "40 mm down": (partial(lifted, -0.04), PoseCause.OFFSET),
    "60 mm up": (partial(lifted, 0.06), PoseCause.OFFSET),
    "60 mm down": (partial(lifted, -0.06), PoseCause.OFFSET),
    "world y up": (partial(posed, lambda pose: Y_UP_FROM_Z_UP @ pose), PoseCause.WORLD_Y_UP),
    "world z down": (partial(posed, lambda pose: UPSIDE_DOWN @ pose), PoseCause.WORLD_Z_DOWN),
    "camera y up": (partial(pointed, lambda points: points * [1.0, -1.0, -1.0]), PoseCause.CAMERA_Y_UP),
    "camera x forward": (partial(pointed, body), PoseCause.CAMERA_X_FORWARD),
    "mirrored pose": (partial(posed, lambda pose: pose @ MIRROR), PoseCause.MIRRORED_POSE),
    "mirrored points": (
        partial(pointed, lambda points: points * (1.0, -1.0, 1.0)),
        PoseCause.MIRRORED_POINTS,
    ),
    "inverse": (partial(posed, inverse), PoseCause.INVERSE),
    "points in mm": (partial(pointed, lambda points: 1000.0 * points), PoseCause.POINTS_MM),
    "pose in mm": (partial(posed, partial(scaled, 1000.0)), PoseCause.POSE_MM),
    "both in mm": (
        lambda scan: SyntheticScan(1000.0 * scan.points, scaled(1000.0, scan.world_from_camera)),
        PoseCause.BOTH_MM,
    ),
    "points in km": (partial(pointed, lambda points: 0.001 * points), PoseCause.POINTS_KM),
    "pose in km": (partial(posed, partial(scaled, 0.001)), PoseCause.POSE_KM),
}


@pytest.fixture(scope="module")
def right() -> list[SyntheticScan]:
    return list(scans(4, seed=11))


@pytest.mark.filterwarnings("ignore::beltsort.perception.UnitWarning")
@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_pose_is_told_with_its_cause(name: str, right: list[SyntheticScan]) -> None:
    spoil, cause = WRONG[name]
    found = []
    for scan in right:
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always", PoseWarning)
            segmented = segment(spoil(scan), LAYOUT)
        if segmented.pose_fault is None:
            assert levelled_all_the_same(spoil(scan), scan)
            continue
        assert any(str(segmented.pose_fault) in str(warning.message) for warning in told)
        found.append(segmented.pose_fault.cause)
    assert found.count(cause) >= len(right) - 2, found


def levelled_all_the_same(spoilt: SyntheticScan, scan: SyntheticScan) -> bool:
    """Whether levelling corrects a wrong pose as it does the right one: the arm's own error may help it."""
    points = scan.points.reshape(-1, 3)
    points = points[np.isfinite(points).all(axis=1)]
    corrected, right = (levelled(points, each.world_from_camera)[2] for each in (spoilt, scan))
    belt = points[np.abs(points @ right[:3] + right[3]) < 0.005]
    return bool(np.abs(belt @ (corrected - right)[:3] + (corrected - right)[3]).mean() < 0.007)


@pytest.mark.parametrize(
    "number", [4, pytest.param(70, marks=pytest.mark.slow)], ids=["few scenes", "two hundred scans"]
)
@pytest.mark.filterwarnings("error::beltsort.perception.PoseWarning")
def test_right_scenes_are_not_warned_about(number: int) -> None:
    found = [segment(scan, LAYOUT).pose_fault for scan in scans(number, seed=100)]
    assert found == [None] * (3 * number)
    for empty in (0.0, 1.0):
        assert all(segment(scan, LAYOUT).pose_fault is None for scan in scans(number // 4, 5, empty))


def test_the_height_of_the_belt_is_told(right: list[SyntheticScan]) -> None:
    with pytest.warns(PoseWarning, match=r"about (50|60|70) mm above z = 0"):
        segment(lifted(0.06, right[0]), LAYOUT)
    assert "about 40 mm below" in str(PoseFault(PoseCause.OFFSET, -0.038))


def test_a_floor_beside_the_belt_is_no_fault(right: list[SyntheticScan]) -> None:
    """Most of the points are a floor's, 0.8 m below the belt."""
    scan = right[0]
    pose = scan.world_from_camera
    rng = np.random.default_rng(3)
    floor = np.column_stack([rng.uniform(-3.0, 3.0, (500_000, 2)), np.full(500_000, -0.8)])
    floor = floor[np.abs(floor[:, 1]) > 0.3]
    points = np.vstack([scan.points.reshape(-1, 3), (floor - pose[:3, 3]) @ pose[:3, :3]])
    level = levelled(points, pose)
    height = points @ level[2, :3] + level[2, 3]
    assert np.mean(np.abs(height[np.isfinite(height)]) < 0.005) < 0.2
    assert pose_fault(points, height, pose, level, LAYOUT) is None


def test_a_scan_without_the_belt_has_no_usual_cause() -> None:
    rng = np.random.default_rng(0)
    cluster = rng.normal((0.0, 0.0, 0.15), 0.03, (2000, 3))
    pose = look_at(np.array([0.3, -0.4, 0.5]), np.zeros(3))
    with pytest.warns(PoseWarning, match="in view"):
        segmented = segment(SyntheticScan((cluster - pose[:3, 3]) @ pose[:3, :3], pose), LAYOUT)
    assert segmented.pose_fault == PoseFault(PoseCause.UNKNOWN)


def test_units_are_still_told(right: list[SyntheticScan]) -> None:
    with pytest.warns(UnitWarning), pytest.warns(PoseWarning, match="millimetres"):
        segment(WRONG["points in mm"][0](right[0]), LAYOUT)
