"""Poses of belt and camera from scans with marks; scans that contradict each other, and the likely cause."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from beltsort.errors import CellError
from beltsort.extrinsics.belt_pose import closed_form, deviations, refined, scale
from beltsort.extrinsics.hand_eye import hand_eye_of
from beltsort.extrinsics.scans import MarkedScan
from beltsort.geometry import Pose, inverse
from beltsort.perception.pose_fault import MOST_TILT, PoseCause, transposed

MOST_OFFSET = 0.04  # metres between a mark and its place; a compliant arm errs by less
MOST_SCALE = 1.1  # ratio of the distances between marks and those between their places


@dataclass(frozen=True)
class Residual:
    """How far one scan deviates from the result.

    Attributes
    ----------
    tilt
        Angle between the plane that it shows and the belt, degrees.
    height
        Height of that plane above the belt, millimetres.
    mark
        Largest distance of a mark from its place, millimetres; None without marks.
    """

    tilt: float
    height: float
    mark: float | None

    @property
    def distance(self) -> float:
        """The larger of height and mark, millimetres."""
        return max(abs(self.height), self.mark or 0.0)

    @property
    def excess(self) -> float:
        """How many times larger it is than that of a scan in a right setup; at most 1 there."""
        return max(self.tilt / MOST_TILT, self.distance / (1000.0 * MOST_OFFSET))


@dataclass(frozen=True, eq=False)
class Calibration:
    """The result of a calibration.

    Attributes
    ----------
    world_from_belt
        Pose of the belt frame, shape (4, 4).
    flange_from_camera
        The hand-eye transform, shape (4, 4); None if it was not sought.
    residuals
        Of each scan.
    scale
        How many times farther apart the marks are seen than their places are.
    redundancy
        Number of measurements beyond those that determine the result; with 0, residuals do not show its
        errors.
    """

    world_from_belt: Pose
    flange_from_camera: Pose | None
    residuals: tuple[Residual, ...]
    scale: float
    redundancy: int

    def plausible(self) -> bool:
        """Whether all scans agree as well as those of a right setup do."""
        return all(residual.excess <= 1.0 for residual in self.residuals)


def calibrate(scans: Sequence[MarkedScan], *, hand_eye: bool = False) -> Calibration:
    """Find the pose of the belt, and the hand-eye transform if it is sought.

    Minimised are the squared deviations of all scans, in the belt frame: of the belt's normal from z, of its
    height from 0, and of the marks from their places, weighted by usual errors (`belt_pose.refined`).

    Parameters
    ----------
    scans
        With the poses of the camera, or of the flange if `hand_eye`.
    hand_eye
        Whether to find `flange_from_camera` too.

    Raises
    ------
    CellError
        If marks or poses do not determine the result, or the scans contradict each other; the message names
        the likely cause.
    """
    result = _calibrated(scans, hand_eye)
    if not result.plausible():
        raise CellError(_contradiction(scans, hand_eye, result))
    if not 1.0 / MOST_SCALE < result.scale < MOST_SCALE:
        raise CellError(f"{_wrong_distances(result.scale)}, or move the objects")
    return result


def _calibrated(scans: Sequence[MarkedScan], hand_eye: bool) -> Calibration:
    flange_from_camera = hand_eye_of(scans) if hand_eye else None
    world_from_belt = closed_form(_of_camera(scans, flange_from_camera))
    world_from_belt, flange_from_camera = refined(scans, world_from_belt, flange_from_camera)
    scans = _of_camera(scans, flange_from_camera)
    errors = [deviations(scan, inverse(world_from_belt) @ scan.pose) for scan in scans]
    return Calibration(
        world_from_belt,
        flange_from_camera,
        tuple(map(_residual, errors)),
        scale(scans),
        sum(map(len, errors)) - (12 if hand_eye else 6),
    )


def _of_camera(scans: Sequence[MarkedScan], flange_from_camera: Pose | None) -> Sequence[MarkedScan]:
    """Return the scans with the poses of the camera."""
    if flange_from_camera is None:
        return scans
    return [replace(scan, pose=scan.pose @ flange_from_camera) for scan in scans]


def _residual(errors: NDArray[np.float64]) -> Residual:
    tilt = np.degrees(np.arcsin(min(1.0, float(np.linalg.norm(errors[:2])))))
    marks = 1000.0 * np.linalg.norm(errors[3:].reshape(-1, 2), axis=1)
    return Residual(float(tilt), 1000.0 * float(errors[2]), float(marks.max()) if len(marks) else None)


def _contradiction(scans: Sequence[MarkedScan], hand_eye: bool, result: Calibration) -> str:
    """Return what contradicts what, and the likely cause."""
    number = int(np.argmax([residual.excess for residual in result.residuals]))
    worst = result.residuals[number]
    mark = "" if worst.mark is None else f", {worst.mark:.0f} mm between mark and place"
    causes = (cause for cause, other in _corrections(scans, result.scale) if _agree(other, hand_eye))
    cause = next(causes, "a mark or a pose is another than the file says: compare them line by line")
    if hand_eye:
        cause = cause.replace("world_from_camera", "world_from_flange").replace("camera_from", "flange_from")
    return (
        f"the scans contradict each other or their marks: {scans[number].file} deviates by {worst.tilt:.1f} "
        f"degrees, {worst.height:.0f} mm in height{mark}, expected at most {MOST_TILT:g} degrees and "
        f"{1000.0 * MOST_OFFSET:g} mm; likely: {cause}"
    )


def _agree(scans: Sequence[MarkedScan], hand_eye: bool) -> bool:
    try:
        return _calibrated(scans, hand_eye).plausible()
    except CellError:
        return False


def _corrections(scans: Sequence[MarkedScan], scale: float) -> Iterator[tuple[str, list[MarkedScan]]]:
    """Yield usual mistakes and the scans without them."""
    for cause, pose_of in ((PoseCause.INVERSE, inverse), (PoseCause.TRANSPOSED, transposed)):
        yield cause, [replace(scan, pose=pose_of(scan.pose)) for scan in scans]
    for cause, factors in (
        (PoseCause.CAMERA_Y_UP, [1.0, -1.0, -1.0]),
        (PoseCause.MIRRORED_POINTS, [1.0, -1.0, 1.0]),
    ):
        landmarks = [scan.landmarks.scaled(np.array(factors)) for scan in scans]
        yield cause, [replace(scan, landmarks=seen) for scan, seen in zip(scans, landmarks, strict=True)]
    yield _wrong_distances(scale), [replace(scan, places=scale * scan.places) for scan in scans]


def _wrong_distances(scale: float) -> str:
    return f"the marks lie {scale:.3g} times as far apart as the file says: correct `marks` (metres)"
