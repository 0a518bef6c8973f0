"""The pose of the belt from scans with marks: in closed form, then by least squares."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from beltsort.errors import CellError
from beltsort.extrinsics.scans import MarkedScan
from beltsort.geometry import Points, Pose, inverse, transform
from beltsort.perception.pose_fault import MOST_TILT, PoseCause, transposed

LEAST_BASELINE = 0.05  # metres; of nearer marks the direction of the belt is worth nothing
MOST_OFFSET = 0.04  # metres between a mark and its place; a compliant arm errs by less
MOST_SCALE = 1.1  # ratio of the distances between marks and those between their places
LEVER = 0.3  # metres; a tilt counts as much as the height that it makes there


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


@dataclass(frozen=True, eq=False)
class Calibration:
    """The result of a calibration.

    Attributes
    ----------
    world_from_belt
        Pose of the belt frame, shape (4, 4).
    residuals
        Of each scan.
    redundancy
        Number of measurements beyond those that determine the result; with 0, residuals do not show its
        errors.
    """

    world_from_belt: Pose
    residuals: tuple[Residual, ...]
    redundancy: int

    def plausible(self) -> bool:
        """Whether all scans agree as well as those of a right setup do."""
        return all(
            r.tilt <= MOST_TILT and max(abs(r.height), r.mark or 0.0) <= 1000.0 * MOST_OFFSET
            for r in self.residuals
        )


def calibrate(scans: Sequence[MarkedScan]) -> Calibration:
    """Find the pose of the belt from the poses of the camera.

    Minimised are the squared deviations of all scans, in the belt frame: of the belt's normal from z, times
    0.3 m, of its height from 0, and of the marks from their places.

    Raises
    ------
    CellError
        If the marks do not determine the pose, or the scans contradict each other; the message names the
        likely cause.
    """
    result = _calibrated(scans)
    if not result.plausible():
        raise CellError(_contradiction(scans, result))
    scale = _scale(scans)
    if not 1.0 / MOST_SCALE < scale < MOST_SCALE:
        raise CellError(
            f"the marks lie {scale:.3g} times as far apart as the file says: correct `marks` (metres), or "
            "move the objects"
        )
    return result


def _calibrated(scans: Sequence[MarkedScan]) -> Calibration:
    world_from_belt = refined(scans, closed_form(scans))
    errors = [_deviations(scan, inverse(world_from_belt) @ scan.pose) for scan in scans]
    measurements = sum(map(len, errors))
    return Calibration(world_from_belt, tuple(map(_residual, errors)), measurements - 6)


def closed_form(scans: Sequence[MarkedScan]) -> Pose:
    """Return `world_from_belt` with the mean plane of the scans, and the mean direction of their marks in it.

    The rotation in the plane is that which minimises the squared distances of marks and places (Procrustes).

    Raises
    ------
    CellError
        If marks stand at one place only.
    """
    places = np.vstack([scan.places for scan in scans])
    if len(places) < 2 or np.linalg.norm(np.ptp(places, axis=0)) < LEAST_BASELINE:
        raise CellError(
            f"marks stand at {np.unique(places, axis=0).tolist()}, expected at least two places, "
            f"{1000.0 * LEAST_BASELINE:.0f} mm or more apart: "
            "scan an object at the belt end and upstream of it"
        )
    normal = np.mean([scan.pose[:3, :3] @ scan.landmarks.normal for scan in scans], axis=0)
    length = np.linalg.norm(normal)
    z = normal / length if length > 0.0 else np.array([0.0, 0.0, 1.0])
    height = np.mean([transform(scan.pose, scan.landmarks.centre) @ z for scan in scans])
    marks = np.vstack([transform(scan.pose, scan.landmarks.marks) for scan in scans])
    x = np.cross(np.eye(3)[np.abs(z).argmin()], z)
    x /= np.linalg.norm(x)
    plane = np.array([x, np.cross(z, x)])  # its axes, (2, 3)
    seen = marks @ plane.T
    a, b = places - places.mean(axis=0), seen - seen.mean(axis=0)
    angle = np.arctan2((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum(), (a * b).sum())
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    pose = np.eye(4)
    pose[:3, :3] = np.column_stack([plane.T @ turn, z])
    pose[:3, 3] = (seen.mean(axis=0) - turn @ places.mean(axis=0)) @ plane + height * z
    return pose


def refined(scans: Sequence[MarkedScan], world_from_belt: Pose) -> Pose:
    """Return the pose near `world_from_belt` that minimises the squared deviations, shape (4, 4)."""

    def deviations(change: NDArray[np.float64]) -> NDArray[np.float64]:
        belt_from_world = inverse(_moved(world_from_belt, change))
        return np.concatenate([_deviations(scan, belt_from_world @ scan.pose) for scan in scans])

    return _moved(world_from_belt, least_squares(deviations, np.zeros(6)).x)


def _moved(pose: Pose, change: NDArray[np.float64]) -> Pose:
    """Return a pose after a motion in its own frame: a rotation vector, radians, and metres, shape (6,)."""
    motion = np.eye(4)
    motion[:3, :3] = Rotation.from_rotvec(change[:3]).as_matrix()
    motion[:3, 3] = change[3:]
    return np.asarray(pose @ motion)


def _deviations(scan: MarkedScan, belt_from_camera: Pose) -> NDArray[np.float64]:
    """Return tilt times LEVER, height, x and y of each mark minus its place; metres, shape (3 + 2 k,)."""
    landmarks = scan.landmarks
    tilt = LEVER * (belt_from_camera[:2, :3] @ landmarks.normal)
    height = transform(belt_from_camera, landmarks.centre)[2:]
    marks = transform(belt_from_camera, landmarks.marks)[:, :2] - scan.places
    return np.concatenate([tilt, height, marks.ravel()])


def _residual(deviations: NDArray[np.float64]) -> Residual:
    tilt = np.degrees(np.arcsin(min(1.0, float(np.linalg.norm(deviations[:2])) / LEVER)))
    marks = 1000.0 * np.linalg.norm(deviations[3:].reshape(-1, 2), axis=1)
    return Residual(float(tilt), 1000.0 * float(deviations[2]), float(marks.max()) if len(marks) else None)


def _contradiction(scans: Sequence[MarkedScan], result: Calibration) -> str:
    """Return what contradicts what, and the likely cause."""
    number = int(np.argmax([max(r.tilt / MOST_TILT, r.mark or 0.0) for r in result.residuals]))
    worst = result.residuals[number]
    mark = "" if worst.mark is None else f", {worst.mark:.0f} mm between mark and place"
    causes = (cause for cause, other in _corrections(scans) if _calibrated(other).plausible())
    cause = next(causes, "a mark or a pose is another than the file says: compare them line by line")
    return (
        f"the scans contradict each other or their marks: {scans[number].file} deviates by {worst.tilt:.1f} "
        f"degrees, {worst.height:.0f} mm in height{mark}, expected at most {MOST_TILT:g} degrees and "
        f"{1000.0 * MOST_OFFSET:g} mm; likely: {cause}"
    )


def _corrections(scans: Sequence[MarkedScan]) -> Iterator[tuple[str, list[MarkedScan]]]:
    """Yield usual mistakes and the scans without them."""
    for cause, pose_of in (
        (PoseCause.INVERSE, inverse),
        (PoseCause.TRANSPOSED, transposed),
    ):
        yield cause, [replace(scan, pose=pose_of(scan.pose)) for scan in scans]
    for cause, factors in (
        (PoseCause.CAMERA_Y_UP, [1.0, -1.0, -1.0]),
        (PoseCause.MIRRORED_POINTS, [1.0, -1.0, 1.0]),
    ):
        landmarks = [scan.landmarks.scaled(np.array(factors)) for scan in scans]
        yield cause, [replace(scan, landmarks=seen) for scan, seen in zip(scans, landmarks, strict=True)]
    scale = _scale(scans)
    apart = f"the marks lie {scale:.3g} times as far apart as the file says: correct `marks` (metres)"
    yield apart, [replace(scan, places=scale * scan.places) for scan in scans]


def _scale(scans: Sequence[MarkedScan]) -> float:
    """Return by how much farther apart the marks are seen than the places say."""

    def spread(points: Points) -> float:
        return float(np.linalg.norm(points - points.mean(axis=0)))

    seen = np.vstack([transform(scan.pose, scan.landmarks.marks) for scan in scans])
    return spread(seen) / spread(np.vstack([scan.places for scan in scans]))
