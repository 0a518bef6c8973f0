"""The pose of the belt from scans with marks: in closed form, and by least squares."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from beltsort.errors import CellError
from beltsort.extrinsics.scans import MarkedScan
from beltsort.geometry import Points, Pose, inverse, transform
from beltsort.util.extras import extra

with extra("perception"):
    from scipy.optimize import least_squares
    from scipy.spatial.transform import Rotation

LEAST_BASELINE = 0.05  # metres; of nearer marks the direction of the belt is worth nothing

ARM_ANGLE, ARM_DISTANCE = np.radians(0.2), 0.0015  # standard deviations of a reported pose, radians, metres
PLANE_ANGLE, PLANE_HEIGHT, MARK = np.radians(0.03), 0.0005, 0.0015  # and of what is measured in a scan


def determine_direction(scans: Sequence[MarkedScan]) -> bool:
    """Whether the marks of scans stand far enough apart to give the belt's direction."""
    places = _places(scans)
    return len(places) > 1 and float(np.linalg.norm(np.ptp(places, axis=0))) >= LEAST_BASELINE


def closed_form(scans: Sequence[MarkedScan]) -> Pose:
    """Return `world_from_belt` with the mean plane of the scans, and the mean direction of their marks in it.

    The rotation in the plane is that which minimises the squared distances of marks and places (Procrustes).

    Parameters
    ----------
    scans
        With the poses of the camera.

    Raises
    ------
    CellError
        If marks stand at one place only.
    """
    places = _places(scans)
    if not determine_direction(scans):
        raise CellError(
            f"marks stand at {np.unique(places, axis=0).tolist()}, expected at least two places, "
            f"{1000.0 * LEAST_BASELINE:.0f} mm or more apart: scan an object at the belt end and "
            "upstream of it"
        )
    normal = np.mean([scan.pose[:3, :3] @ scan.landmarks.normal for scan in scans], axis=0)
    length = np.linalg.norm(normal)
    z = normal / length if length > 0.0 else np.array([0.0, 0.0, 1.0])
    height = np.mean([transform(scan.pose, scan.landmarks.centre) @ z for scan in scans])
    x = np.cross(np.eye(3)[np.abs(z).argmin()], z)
    x /= np.linalg.norm(x)
    plane = np.array([x, np.cross(z, x)])  # its axes, (2, 3)
    seen = marks_in_world(scans) @ plane.T
    a, b = places - places.mean(axis=0), seen - seen.mean(axis=0)
    angle = np.arctan2((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum(), (a * b).sum())
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    pose = np.eye(4)
    pose[:3, :3] = np.column_stack([plane.T @ turn, z])
    pose[:3, 3] = (seen.mean(axis=0) - turn @ places.mean(axis=0)) @ plane + height * z
    return pose


def refined(
    scans: Sequence[MarkedScan], world_from_belt: Pose, flange_from_camera: Pose | None = None
) -> tuple[Pose, Pose | None]:
    """Return the poses near the given ones that minimise the squared deviations of all scans.

    The deviations of a scan are weighted by the inverse of their covariance, that is, by usual errors of arm
    and camera: an error of the camera's orientation tilts the plane and shifts all marks together.

    Parameters
    ----------
    scans
        With the poses of the flange if `flange_from_camera` is given, and of the camera otherwise.
    world_from_belt, flange_from_camera
        Where to start, shape (4, 4).
    """
    start = [world_from_belt] if flange_from_camera is None else [world_from_belt, flange_from_camera]

    def moved(changes: NDArray[np.float64]) -> list[Pose]:
        return [_moved(pose, change) for pose, change in zip(start, changes.reshape(-1, 6), strict=True)]

    def in_belt(belt: Pose, hand_eye: Pose | None = None) -> list[Pose]:
        of_flange = [inverse(belt) @ scan.pose for scan in scans]
        return of_flange if hand_eye is None else [pose @ hand_eye for pose in of_flange]

    def all_deviations(changes: NDArray[np.float64]) -> NDArray[np.float64]:
        cameras = in_belt(*moved(changes))
        triples = zip(weights, scans, cameras, strict=True)
        return np.concatenate([weight @ deviations(scan, camera) for weight, scan, camera in triples])

    weights = [_weight(scan, camera) for scan, camera in zip(scans, in_belt(*start), strict=True)]
    belt, *hand_eye = moved(least_squares(all_deviations, np.zeros(6 * len(start))).x)
    return belt, hand_eye[0] if hand_eye else None


def deviations(scan: MarkedScan, belt_from_camera: Pose) -> NDArray[np.float64]:
    """Return by how much a scan deviates from a belt, shape (3 + 2 k,).

    These are x and y of its normal, the height of its plane, metres, and x and y of each mark minus those of
    its place, metres.
    """
    landmarks = scan.landmarks
    tilt = belt_from_camera[:2, :3] @ landmarks.normal
    height = transform(belt_from_camera, landmarks.centre)[2:]
    marks = transform(belt_from_camera, landmarks.marks)[:, :2] - scan.places
    return np.concatenate([tilt, height, marks.ravel()])


def _weight(scan: MarkedScan, belt_from_camera: Pose) -> NDArray[np.float64]:
    """Return W with W^T W the inverse of the covariance of a scan's deviations, (3 + 2 k, 3 + 2 k)."""
    landmarks = scan.landmarks
    turned = belt_from_camera[:3, :3]

    def moves(point: Points) -> Points:
        """Return how a point moves with the camera's turn, radians, and shift, metres: shape (3, 6)."""
        return np.hstack([turned @ np.cross(np.eye(3), point).T, turned])

    of_normal = moves(landmarks.normal)[:2] * [1.0, 1.0, 1.0, 0.0, 0.0, 0.0]
    by_pose = np.vstack(
        [of_normal, moves(landmarks.centre)[2:], *(moves(mark)[:2] for mark in landmarks.marks)]
    )
    pose = np.repeat([ARM_ANGLE, ARM_DISTANCE], 3)
    measured = np.array([PLANE_ANGLE] * 2 + [PLANE_HEIGHT] + [MARK] * (2 * len(landmarks.marks)))
    covariance = (by_pose * pose**2) @ by_pose.T + np.diag(measured**2)
    return np.asarray(np.linalg.inv(np.linalg.cholesky(covariance)))


def scale(scans: Sequence[MarkedScan]) -> float:
    """Return how many times farther apart the marks are seen than their places are."""

    def spread(points: Points) -> float:
        return float(np.linalg.norm(points - points.mean(axis=0)))

    return spread(marks_in_world(scans)) / spread(_places(scans))


def marks_in_world(scans: Sequence[MarkedScan]) -> Points:
    """Return the marks of all scans, world frame, metres, shape (k, 3)."""
    return np.vstack([transform(scan.pose, scan.landmarks.marks) for scan in scans])


def _places(scans: Sequence[MarkedScan]) -> Points:
    return np.vstack([scan.places for scan in scans])


def _moved(pose: Pose, change: NDArray[np.float64]) -> Pose:
    """Return a pose after a motion in its own frame: a rotation vector, radians, and metres, shape (6,)."""
    motion = np.eye(4)
    motion[:3, :3] = Rotation.from_rotvec(change[:3]).as_matrix()
    motion[:3, 3] = change[3:]
    return np.asarray(pose @ motion)
