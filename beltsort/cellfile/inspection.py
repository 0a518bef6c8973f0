"""Measurements of the belt plane and the positions in a scan, and what perception finds there."""

from dataclasses import dataclass

import numpy as np

from beltsort.cell.protocols import Scan
from beltsort.errors import CloudError
from beltsort.geometry import BeltLayout, Points, Pose, transform
from beltsort.perception import Finding, PerceptionConfig, PoseFault, segment
from beltsort.perception.checks import counted_warnings
from beltsort.perception.level import BANDS, levelled

BELOW = 0.01  # metres; points in a crop may be this far below the belt, because of noise
RING = 24  # sample points on the circle at each end of a crop cylinder


@dataclass(frozen=True)
class SeenBelt:
    """The belt plane fitted to a scan, relative to the expected plane z = 0.

    Attributes
    ----------
    angle
        Angle between the two planes, degrees.
    height
        Height of the fitted plane at the belt end, millimetres.
    points
        Number of points on the fitted plane; if there are few, angle and height are meaningless.
    """

    angle: float
    height: float
    points: int


@dataclass(frozen=True)
class SeenCrop:
    """Coverage of the crop cylinder of one position by a scan.

    Attributes
    ----------
    inside
        Share of the cylinder's upper and lower edge, above the rim, that lies inside the image; None if the
        scan is not organised.
    points
        Number of points in the cylinder, including those of cup and belt.
    """

    inside: float | None
    points: int


def seen_belt(scan: Scan) -> SeenBelt:
    """Fit the belt plane to a scan."""
    points = finite_points(scan)
    pose = levelled(points, scan.world_from_camera)
    correction = pose @ np.linalg.inv(scan.world_from_camera)  # maps the fitted plane to z = 0
    upright = float(np.clip(correction[2, 2], -1.0, 1.0))
    on_belt = np.abs(transform(pose, points)[:, 2]) < BANDS[-1]
    return SeenBelt(
        angle=float(np.degrees(np.arccos(upright))),
        height=float(-1000.0 * correction[2, 3] / upright),
        points=int(on_belt.sum()),
    )


def seen_crops(scan: Scan, layout: BeltLayout) -> tuple[SeenCrop, ...]:
    """Return the coverage of each position's crop cylinder, the belt end first."""
    points = finite_points(scan)
    pose = levelled(points, scan.world_from_camera)
    world = transform(pose, points)
    crops = []
    for position in range(layout.positions):
        offset = world - layout.centre(position)
        near = np.hypot(offset[:, 0], offset[:, 1]) < layout.crop_radius
        within = near & (offset[:, 2] > -BELOW) & (offset[:, 2] < layout.crop_height)
        crops.append(SeenCrop(_inside(scan.points, pose, layout, position), int(within.sum())))
    return tuple(crops)


def seen_findings(
    scan: Scan, layout: BeltLayout, config: PerceptionConfig | None = None
) -> tuple[tuple[Finding, ...], PoseFault | None]:
    """Return what perception finds at each position, and the likely fault of the scan's pose.

    A scan without a finite point has no findings.
    """
    try:
        with counted_warnings():
            segmented = segment(scan, layout, config)
    except CloudError:
        return (), None
    return segmented.findings, segmented.pose_fault


def finite_points(scan: Scan) -> Points:
    """Return the finite points of a scan, camera frame, shape (n, 3)."""
    points = scan.points.reshape(-1, 3)
    finite: Points = points[np.isfinite(points).all(axis=1)]
    return finite


def _inside(image: Points, pose: Pose, layout: BeltLayout, position: int) -> float | None:
    """Return the share of the crop's edges inside an organised image; None if it is not organised."""
    if image.ndim != 3 or not np.isfinite(image).all(axis=-1).any():
        return None
    rings = (_rings(layout, position) - pose[:3, 3]) @ pose[:3, :3]  # camera frame
    inside = rings[:, 2] > 0.0
    for axis, size in ((0, image.shape[1]), (1, image.shape[0])):
        pixel = np.polyval(_projection(image, axis), rings[:, axis] / rings[:, 2])
        inside &= (pixel > -0.5) & (pixel < size - 0.5)
    return float(inside.mean())


def _rings(layout: BeltLayout, position: int) -> Points:
    """Return points on the edges of a crop cylinder, lower one first, world frame, shape (2 RING, 3)."""
    angle = np.linspace(0.0, 2.0 * np.pi, RING, endpoint=False)
    circle: Points = layout.crop_radius * np.column_stack([np.cos(angle), np.sin(angle), np.zeros(RING)])
    ends = [[0.0, 0.0, layout.rim_height], [0.0, 0.0, layout.crop_height]]
    rings: Points = np.vstack([circle + layout.centre(position) + end for end in ends])
    return rings


def _projection(image: Points, axis: int) -> Points:
    """Return (focal length, principal point), pixels, of a pinhole image along x (0) or y (1).

    They are fitted to the points, since a scan does not contain the camera's intrinsics.
    """
    seen = np.isfinite(image).all(axis=-1)
    pixels = np.argwhere(seen)[:, 1 - axis]
    slopes = image[seen][:, axis] / image[seen][:, 2]
    return np.polyfit(slopes, pixels, 1)
