"""Poses under which a scan does not show the belt where it should be, and what is likely wrong with them.

Levelling corrects a few centimetres and degrees. If hardly any point lies on the belt plane afterwards, or
only after a large turn, then pose or points follow another convention, or the belt stands elsewhere, and the
crops miss their cups. A wrong x, y or heading leaves the belt in its plane, and so does a mirror image from
some viewpoints: they are not detected.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from beltsort.geometry import BeltLayout, Points, Pose, inverse, transform
from beltsort.perception.level import BANDS, REACH, levelled

LEAST_SHARE = 0.2
"""Share of points on the belt plane, below which a pose is at fault; right scenes have 0.55 and more."""

MOST_TILT = 5.0
"""Degrees between the belt plane seen and the one the pose says; an arm errs by 2 at most."""

SAMPLES = 20_000
TRIAL_SAMPLES = 4_000
FEWEST_NEAR = 0.05  # of the sample; fewer points near the positions say nothing about the belt there
TIE = (
    0.05  # of the share; of causes that explain a scan so equally well, the first of `_corrections` is named
)
FARTHEST_PLANE = 0.5  # metres above or below z = 0, for an offset
PLANE_STEP = 0.01  # metres between the heights tried
LOWEST_CAMERA = 0.05  # metres above the belt


class PoseCause(StrEnum):
    """What is likely wrong with the pose of a scan, or with its points.

    Examples
    --------
    >>> print(PoseCause.INVERSE)
    the pose is inverted: give world_from_camera, not camera_from_world
    """

    OFFSET = "the belt plane lies off z = 0: correct the camera's height over the belt"
    MIRRORED_POSE = "the pose mirrors (its determinant is negative): give a rotation and a translation"
    POINTS_MM = "the points are in millimetres: multiply them by 0.001"
    POSE_MM = "the pose is in millimetres: multiply its translation by 0.001"
    BOTH_MM = "points and pose are in millimetres: multiply the points and the translation by 0.001"
    POINTS_KM = "the points are too small by a factor of 1000: multiply them by 1000"
    POSE_KM = "the pose's translation is too small by a factor of 1000: multiply it by 1000"
    INVERSE = "the pose is inverted: give world_from_camera, not camera_from_world"
    TRANSPOSED = "the pose's rotation is transposed: give that of world_from_camera"
    WORLD_Y_UP = "the world's y axis points up: rotate the pose so that z does"
    WORLD_Z_DOWN = "the world's z axis points down: rotate the pose so that it points up"
    CAMERA_Y_UP = "the camera frame has y up and z backward: give points with y down and z forward"
    CAMERA_X_FORWARD = "the camera frame has x forward and z up: give the optical frame, z forward"
    MIRRORED_POINTS = "the points are mirrored, y up and z forward: give points with y down"
    TILTED = "the pose is tilted against the belt: correct the hand-eye transform or the belt frame"
    UNKNOWN = "no usual mistake explains it: check the pose, and that the belt is in view"


@dataclass(frozen=True)
class PoseFault:
    """A scan does not show the belt where its pose says.

    Attributes
    ----------
    cause
        The likely cause.
    height
        Height of the plane that was found instead, metres; None unless the cause is an offset.

    Examples
    --------
    >>> print(PoseFault(PoseCause.OFFSET, 0.04))
    the belt plane lies about 40 mm above z = 0: correct the camera's height over the belt
    """

    cause: PoseCause
    height: float | None = None

    def __str__(self) -> str:
        """Return the cause and its remedy; a height to 10 mm."""
        if self.height is None:
            return str(self.cause)
        side = "above" if self.height > 0.0 else "below"
        return self.cause.replace(
            "off z = 0", f"about {10.0 * round(100.0 * abs(self.height)):g} mm {side} z = 0"
        )


def pose_fault(
    points: Points, height: NDArray[np.float64], world_from_camera: Pose, level: Pose, layout: BeltLayout
) -> PoseFault | None:
    """Return what is wrong with the pose of a scan; None if it shows the belt where it should be.

    Parameters
    ----------
    points
        Shape (n, 3), camera frame, metres; points that are not finite are ignored.
    height
        Their height above the belt under `level`, shape (n,), metres.
    world_from_camera
        The reported pose, shape (4, 4).
    level
        What `levelled` returned for it, shape (4, 4).
    layout
        Positions of the cups.
    """
    if np.linalg.det(world_from_camera[:3, :3]) < 0.0:
        return PoseFault(PoseCause.MIRRORED_POSE)
    step = 1 + len(points) // SAMPLES
    sampled = height[::step]
    finite = np.isfinite(sampled)
    upright = level[2, 3] > 0.0 and _tilt(world_from_camera, level) <= MOST_TILT
    on_belt = np.abs(sampled[finite]) < BANDS[-1]
    if len(on_belt) == 0 or (upright and on_belt.mean() >= LEAST_SHARE):
        return None
    sample = points[::step][finite]
    if upright and _near_ones_on_belt(transform(level, sample), on_belt, layout):
        return None
    return _diagnosis(sample[:: 1 + len(sample) // TRIAL_SAMPLES], world_from_camera, level, layout)


def _near_ones_on_belt(world: Points, on_belt: NDArray[np.bool_], layout: BeltLayout) -> bool:
    """Whether enough points near the positions lie on the belt, so that all others may be a floor's."""
    near = _near_positions(world, layout)
    return bool(near.mean() >= FEWEST_NEAR and on_belt[near].mean() >= LEAST_SHARE)


def _diagnosis(points: Points, world_from_camera: Pose, level: Pose, layout: BeltLayout) -> PoseFault:
    """Return the first cause without which the scan would show the belt about as well as without any."""
    fits = [
        (_fit(corrected, pose, layout), fault)
        for fault, corrected, pose in _corrections(points, world_from_camera, level)
    ]
    best = max(fit for fit, _ in fits)
    if best < LEAST_SHARE:
        return PoseFault(PoseCause.UNKNOWN)
    return next(fault for fit, fault in fits if fit >= best - TIE)


def _fit(points: Points, world_from_camera: Pose, layout: BeltLayout) -> float:
    """Return the share of points on the belt plane near the positions, under a pose yet to be levelled."""
    level = levelled(points, world_from_camera)
    if not LOWEST_CAMERA < level[2, 3] < REACH or _tilt(world_from_camera, level) > MOST_TILT:
        return 0.0
    world = transform(level, points)
    return float((_near_positions(world, layout) & (np.abs(world[:, 2]) < BANDS[-1])).mean())


def _tilt(world_from_camera: Pose, level: Pose) -> float:
    """Return the angle by which levelling turned a pose, degrees."""
    return float(np.degrees(np.arccos(np.clip(world_from_camera[2, :3] @ level[2, :3], -1.0, 1.0))))


def _near_positions(world: Points, layout: BeltLayout) -> NDArray[np.bool_]:
    """Return which points, world frame, are at most one spacing from the positions, shape (n,)."""
    x, y = world[:, 0], world[:, 1]
    first, last = layout.extent
    return (x > first - layout.spacing) & (x < last + layout.spacing) & (np.abs(y) < layout.spacing)


def _corrections(points: Points, pose: Pose, level: Pose) -> Iterator[tuple[PoseFault, Points, Pose]]:
    """Yield each fault with points and pose as they would be without it, the more usual ones first."""
    height = _plane_height(points, pose)
    yield PoseFault(PoseCause.OFFSET, height), points, _lifted(pose, -height)
    for cause, for_points, for_pose in (
        (PoseCause.POINTS_MM, 0.001, 1.0),
        (PoseCause.POSE_MM, 1.0, 0.001),
        (PoseCause.BOTH_MM, 0.001, 0.001),
        (PoseCause.POINTS_KM, 1000.0, 1.0),
        (PoseCause.POSE_KM, 1.0, 1000.0),
    ):
        yield PoseFault(cause), for_points * points, _scaled(pose, for_pose)
    yield PoseFault(PoseCause.INVERSE), points, inverse(pose)
    yield PoseFault(PoseCause.CAMERA_Y_UP), points * [1.0, -1.0, -1.0], pose
    yield PoseFault(PoseCause.WORLD_Y_UP), points, _rotated(_Z_FROM_Y, pose)
    yield PoseFault(PoseCause.WORLD_Z_DOWN), points, _rotated(np.diag([1.0, -1.0, -1.0]), pose)
    yield PoseFault(PoseCause.CAMERA_X_FORWARD), points @ _OPTICAL_FROM_BODY.T, pose
    yield PoseFault(PoseCause.TRANSPOSED), points, transposed(pose)
    yield PoseFault(PoseCause.MIRRORED_POINTS), points * [1.0, -1.0, 1.0], pose
    yield PoseFault(PoseCause.TILTED), points, level


_Z_FROM_Y = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
_OPTICAL_FROM_BODY = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])


def _plane_height(points: Points, pose: Pose) -> float:
    """Return the height, metres, at which most points lie, in the world frame and near z = 0."""
    z = points @ pose[2, :3] + pose[2, 3]
    edges = np.arange(-FARTHEST_PLANE, FARTHEST_PLANE + PLANE_STEP, PLANE_STEP)
    count, _ = np.histogram(z, edges)
    pairs = count[:-1] + count[1:]  # a plane may lie across an edge
    if not pairs.any():
        return 0.0
    middle = edges[pairs.argmax() + 1]
    return float(np.median(z[np.abs(z - middle) <= PLANE_STEP]))


def _lifted(pose: Pose, by: float) -> Pose:
    lifted = pose.copy()
    lifted[2, 3] += by
    return lifted


def _scaled(pose: Pose, factor: float) -> Pose:
    scaled = pose.copy()
    scaled[:3, 3] *= factor
    return scaled


def _rotated(rotation: Points, pose: Pose) -> Pose:
    rotated = pose.copy()
    rotated[:3] = rotation @ pose[:3]
    return rotated


def transposed(pose: Pose) -> Pose:
    """Return the pose with its rotation transposed, shape (4, 4)."""
    transposed = pose.copy()
    transposed[:3, :3] = pose[:3, :3].T
    return transposed
