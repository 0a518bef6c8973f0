"""The hand-eye transform, from exact poses and from scans of the simulated camera."""

from dataclasses import replace

import numpy as np
import pytest

from beltsort.cell.arrival import deviation
from beltsort.errors import CellError
from beltsort.extrinsics.calibration import calibrate
from beltsort.extrinsics.hand_eye import hand_eye_of, park_martin
from beltsort.extrinsics.scans import MarkedScan
from beltsort.geometry import Pose, inverse
from beltsort.perception import PoseCause
from beltsort.sim.config import ArmErrors
from tests.extrinsics.marked import PRECISE, marked_scans, one_mark, pose_of, poses

WORLD_FROM_BELT = pose_of([0.1, -0.2, 1.5], [0.5, -0.2, 0.1])
FLANGE_FROM_CAMERA = pose_of([0.05, -0.1, 0.8], [0.02, 0.05, 0.03])


def flange_poses(belt_from_camera: list[Pose]) -> list[Pose]:
    return [WORLD_FROM_BELT @ pose @ inverse(FLANGE_FROM_CAMERA) for pose in belt_from_camera]


def scans_of_flange(count: int, arm: ArmErrors = PRECISE) -> list[MarkedScan]:
    return marked_scans(WORLD_FROM_BELT, count, arm, FLANGE_FROM_CAMERA)


@pytest.mark.parametrize("count", [3, 4, 10])
def test_exact_poses_give_the_exact_transform(count: int) -> None:
    cameras = poses(count)
    found = park_martin(flange_poses(cameras), [inverse(pose) for pose in cameras])
    np.testing.assert_allclose(found, FLANGE_FROM_CAMERA, atol=1e-9)


def test_the_transform_is_found_from_scans() -> None:
    result = calibrate(scans_of_flange(12), hand_eye=True)
    assert result.flange_from_camera is not None
    assert not deviation(result.flange_from_camera, FLANGE_FROM_CAMERA).exceeds(angle=0.2, distance=3.0)
    assert not deviation(result.world_from_belt, WORLD_FROM_BELT).exceeds(angle=0.2, distance=2.0)
    assert all(residual.tilt < 0.2 and abs(residual.height) < 1.5 for residual in result.residuals)
    assert result.redundancy == 12 * 7 - 12


def test_errors_of_a_compliant_arm_average_out() -> None:
    result = calibrate(scans_of_flange(40, ArmErrors()), hand_eye=True)
    assert result.flange_from_camera is not None
    assert not deviation(result.flange_from_camera, FLANGE_FROM_CAMERA).exceeds(angle=0.4, distance=3.0)
    assert not deviation(result.world_from_belt, WORLD_FROM_BELT).exceeds(angle=0.3, distance=3.0)


def test_least_squares_improve_on_the_closed_form() -> None:
    """Over ten draws of a compliant arm's errors, since in a single one chance decides."""
    closed, refined = [], []
    for seed in range(10):
        rng = np.random.default_rng(seed)
        scans = [replace(scan, pose=ArmErrors().true_pose(scan.pose, rng)) for scan in scans_of_flange(24)]
        result = calibrate(scans, hand_eye=True)
        assert result.flange_from_camera is not None
        closed.append(deviation(hand_eye_of(scans), FLANGE_FROM_CAMERA))
        refined.append(deviation(result.flange_from_camera, FLANGE_FROM_CAMERA))
    assert sum(d.angle for d in refined) < sum(d.angle for d in closed)
    assert sum(d.distance for d in refined) < sum(d.distance for d in closed)


def test_an_object_that_is_moved_while_the_arm_stands_serves_as_well() -> None:
    scans = [one_mark(scan, k) for k in (0, 1) for scan in scans_of_flange(8)]
    found = calibrate(scans, hand_eye=True).flange_from_camera
    assert found is not None
    assert not deviation(found, FLANGE_FROM_CAMERA).exceeds(angle=0.3, distance=3.0)


def test_the_order_of_scans_does_not_matter() -> None:
    scans = scans_of_flange(8)
    first, second = (calibrate(some, hand_eye=True) for some in (scans, scans[::-1]))
    np.testing.assert_allclose(first.world_from_belt, second.world_from_belt, atol=1e-6)
    assert first.flange_from_camera is not None
    assert second.flange_from_camera is not None
    np.testing.assert_allclose(first.flange_from_camera, second.flange_from_camera, atol=1e-6)


def test_a_motion_of_the_world_moves_the_belt_only() -> None:
    scans, motion = scans_of_flange(8), pose_of([0.5, -1.0, 2.0], [1.0, -2.0, 0.3])
    here = calibrate(scans, hand_eye=True)
    there = calibrate([replace(scan, pose=motion @ scan.pose) for scan in scans], hand_eye=True)
    np.testing.assert_allclose(there.world_from_belt, motion @ here.world_from_belt, atol=1e-6)
    assert here.flange_from_camera is not None
    assert there.flange_from_camera is not None
    np.testing.assert_allclose(there.flange_from_camera, here.flange_from_camera, atol=1e-6)


def test_poses_that_do_not_determine_it_are_refused() -> None:
    scans = scans_of_flange(5)
    for some, message in (
        (scans[:2], "2 of 2 poses of the flange show marks at two places, expected at least 3"),
        ([*scans[:2], *(one_mark(scan, 0) for scan in scans[2:])], "2 of 5 poses"),
        ([scans[0]] * 3, "1 of 1 poses"),
    ):
        with pytest.raises(CellError, match=message):
            calibrate(some, hand_eye=True)


@pytest.mark.parametrize("turn", [0.0, 0.5])
def test_turns_about_one_axis_are_refused(turn: float) -> None:
    steps = [pose_of([0.0, turn * n, 0.0], [0.1 * n, 0.02 * n**2, -0.05 * n]) for n in range(5)]
    cameras = [poses(1)[0] @ step for step in steps]
    with pytest.raises(CellError, match=r"about a second axis the flange turns by .* expected 5 or more"):
        park_martin(flange_poses(cameras), [inverse(pose) for pose in cameras])


def test_usual_mistakes_are_named() -> None:
    scans = scans_of_flange(8)
    mirrored = np.array([1.0, -1.0, 1.0])
    for cause, wrong in (
        ("world_from_flange, not flange_from_world", [replace(s, pose=inverse(s.pose)) for s in scans]),
        (PoseCause.MIRRORED_POINTS, [replace(s, landmarks=s.landmarks.scaled(mirrored)) for s in scans]),
    ):
        with pytest.raises(CellError) as raised:
            calibrate(wrong, hand_eye=True)
        assert cause in str(raised.value)
