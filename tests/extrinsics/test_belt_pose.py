"""The pose of the belt, from scans of the simulated camera."""

from dataclasses import replace

import numpy as np
import pytest

from beltsort.cell.arrival import deviation
from beltsort.errors import CellError
from beltsort.extrinsics.calibration import calibrate
from beltsort.extrinsics.scans import MarkedScan
from beltsort.geometry import inverse
from beltsort.perception import PoseCause
from beltsort.sim.config import ArmErrors
from tests.extrinsics.marked import marked_scans, one_mark, pose_of

WORLD_FROM_BELT = pose_of([0.1, -0.2, 1.5], [0.5, -0.2, 0.1])


@pytest.fixture(scope="module")
def scans() -> list[MarkedScan]:
    return marked_scans(WORLD_FROM_BELT, 6)


def test_the_pose_is_found(scans: list[MarkedScan]) -> None:
    result = calibrate(scans)
    assert not deviation(result.world_from_belt, WORLD_FROM_BELT).exceeds(angle=0.1, distance=1.0)
    assert all(residual.tilt < 0.1 and abs(residual.height) < 1.0 for residual in result.residuals)
    assert all(residual.mark is not None and residual.mark < 3.0 for residual in result.residuals)
    assert result.redundancy == 6 * 7 - 6


def test_one_scan_suffices(scans: list[MarkedScan]) -> None:
    for scan in scans:
        found = calibrate([scan]).world_from_belt
        assert not deviation(found, WORLD_FROM_BELT).exceeds(angle=0.3, distance=3.0)


def test_errors_of_a_compliant_arm_average_out() -> None:
    result = calibrate(marked_scans(WORLD_FROM_BELT, 40, ArmErrors()))
    assert not deviation(result.world_from_belt, WORLD_FROM_BELT).exceeds(angle=0.3, distance=2.0)


def test_an_object_that_is_moved_between_scans_serves_as_well(scans: list[MarkedScan]) -> None:
    moved = [one_mark(scan, n % 2) for n, scan in enumerate(scans)]
    empty = replace(
        scans[0], places=np.empty((0, 2)), landmarks=replace(scans[0].landmarks, marks=np.empty((0, 3)))
    )
    result = calibrate([*moved, empty])
    assert not deviation(result.world_from_belt, WORLD_FROM_BELT).exceeds(angle=0.3, distance=2.0)
    assert result.residuals[-1].mark is None


def test_the_order_of_scans_does_not_matter(scans: list[MarkedScan]) -> None:
    found = calibrate(scans[::-1]).world_from_belt
    np.testing.assert_allclose(found, calibrate(scans).world_from_belt, atol=1e-7)


@pytest.mark.parametrize("turn", [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.5, -1.0, 2.0]])
def test_a_motion_of_the_world_moves_the_result(scans: list[MarkedScan], turn: list[float]) -> None:
    motion = pose_of(turn, [1.0, -2.0, 0.3])
    found = calibrate([replace(scan, pose=motion @ scan.pose) for scan in scans]).world_from_belt
    np.testing.assert_allclose(found, motion @ calibrate(scans).world_from_belt, atol=1e-7)


def test_marks_at_one_place_are_refused(scans: list[MarkedScan]) -> None:
    with pytest.raises(CellError, match=r"marks stand at \[\[0.0, 0.0\]\], expected at least two places"):
        calibrate([one_mark(scan, 0) for scan in scans])


def test_usual_mistakes_are_named(scans: list[MarkedScan]) -> None:
    flipped = np.array([1.0, -1.0, -1.0])
    mirrored = np.array([1.0, -1.0, 1.0])
    mistakes = {
        PoseCause.INVERSE: [replace(scan, pose=inverse(scan.pose)) for scan in scans],
        PoseCause.CAMERA_Y_UP: [replace(scan, landmarks=scan.landmarks.scaled(flipped)) for scan in scans],
        PoseCause.MIRRORED_POINTS: [
            replace(scan, landmarks=scan.landmarks.scaled(mirrored)) for scan in scans
        ],
        "the marks lie 0.000997 times as far": [replace(scan, places=1000.0 * scan.places) for scan in scans],
        "another than the file says": [replace(scans[0], places=scans[0].places[::-1]), *scans[1:]],
    }
    for cause, wrong in mistakes.items():
        with pytest.raises(CellError) as raised:
            calibrate(wrong)
        assert cause in str(raised.value)
    assert "0.npy deviates" in str(raised.value)


def test_a_wrong_distance_between_the_marks_is_told(scans: list[MarkedScan]) -> None:
    with pytest.raises(CellError, match=r"lie 1.1\d times as far apart"):
        calibrate([replace(scan, places=scan.places / 1.15) for scan in scans])
