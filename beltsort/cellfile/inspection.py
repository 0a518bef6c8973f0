"""What a scan shows of the belt and of the places on it, in numbers."""

from dataclasses import dataclass

import numpy as np

from beltsort.cell.protocols import Scan
from beltsort.geometry import BeltLayout, Points, Pose, transform
from beltsort.perception.level import BANDS, levelled

BELOW = 0.01  # metres; so much below the belt still counts as seen in a crop: noise
RING = 24  # points about each end of a crop cylinder


@dataclass(frozen=True)
class SeenBelt:
    """Where the belt is seen, against the plane z = 0 where it should be.

    Attributes
    ----------
    angle
        Between the two planes, degrees.
    height
        Of the seen belt at the belt end, millimetres.
    points
        Points of the scan that lie on it; few or none mean that angle and height say nothing.
    """

    angle: float
    height: float
    points: int


@dataclass(frozen=True)
class SeenCrop:
    """What is seen of the upright cylinder in which the object of one position is sought.

    Attributes
    ----------
    inside
        Share of the cylinder's surface above the rim that lies inside the image; None if the scan is no
        organised image.
    points
        Points of the scan in the cylinder, cup and belt included.
    """

    inside: float | None
    points: int


def seen_belt(scan: Scan) -> SeenBelt:
    """Return where a scan shows the belt."""
    points = finite_points(scan)
    pose = levelled(points, scan.world_from_camera)
    correction = pose @ np.linalg.inv(scan.world_from_camera)  # lays the seen belt into z = 0
    upright = float(np.clip(correction[2, 2], -1.0, 1.0))
    on_belt = np.abs(transform(pose, points)[:, 2]) < BANDS[-1]
    return SeenBelt(
        angle=float(np.degrees(np.arccos(upright))),
        height=float(-1000.0 * correction[2, 3] / upright),
        points=int(on_belt.sum()),
    )


def seen_crops(scan: Scan, layout: BeltLayout) -> tuple[SeenCrop, ...]:
    """Return what a scan shows of each position's crop cylinder, the belt end first."""
    points = finite_points(scan)
    pose = levelled(points, scan.world_from_camera)
    world = transform(pose, points)
    return tuple(
        SeenCrop(_inside(scan.points, pose, layout, position), _points_in(world, layout, position))
        for position in range(layout.positions)
    )


def finite_points(scan: Scan) -> Points:
    """Return the points of a scan that are numbers, camera frame, shape (n, 3)."""
    points = scan.points.reshape(-1, 3)
    finite: Points = points[np.isfinite(points).all(axis=1)]
    return finite


def _points_in(world: Points, layout: BeltLayout, position: int) -> int:
    offset = world - layout.centre(position)
    near = np.hypot(offset[:, 0], offset[:, 1]) < layout.crop_radius
    return int((near & (offset[:, 2] > -BELOW) & (offset[:, 2] < layout.crop_height)).sum())


def _inside(image: Points, pose: Pose, layout: BeltLayout, position: int) -> float | None:
    """Return the share of the crop's rings that an organised image could show."""
    if image.ndim != 3 or not np.isfinite(image).all(axis=-1).any():
        return None
    rings = (_rings(layout, position) - pose[:3, 3]) @ pose[:3, :3]  # camera frame
    inside = rings[:, 2] > 0.0
    for axis, size in ((0, image.shape[1]), (1, image.shape[0])):
        pixel = np.polyval(_projection(image, axis), rings[:, axis] / rings[:, 2])
        inside &= (pixel > -0.5) & (pixel < size - 0.5)
    return float(inside.mean())


def _rings(layout: BeltLayout, position: int) -> Points:
    """Return points about the lower and the upper end of a crop cylinder, shape (2 RING, 3), world frame."""
    angle = np.linspace(0.0, 2.0 * np.pi, RING, endpoint=False)
    circle: Points = layout.crop_radius * np.column_stack([np.cos(angle), np.sin(angle), np.zeros(RING)])
    ends = [[0.0, 0.0, layout.rim_height], [0.0, 0.0, layout.crop_height]]
    rings: Points = np.vstack([circle + layout.centre(position) + end for end in ends])
    return rings


def _projection(image: Points, axis: int) -> Points:
    """Return (focal length, principal point), pixels, of a pinhole image along x (0) or y (1).

    Fitted to its points, since a scan does not tell the camera's intrinsics.
    """
    seen = np.isfinite(image).all(axis=-1)
    pixels = np.argwhere(seen)[:, 1 - axis]
    slopes = image[seen][:, axis] / image[seen][:, 2]
    return np.polyfit(slopes, pixels, 1)
