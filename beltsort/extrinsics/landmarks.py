"""The belt's plane in a cloud, and the marks on it: objects that stand at known places.

A camera sees only one side of an object, whose centroid therefore lies too near the camera. The top face is
seen from everywhere above it, so the place of a mark is the centroid of its top, projected on the belt.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from beltsort import _core
from beltsort.errors import CloudError
from beltsort.geometry import Points, Pose, inverse, transform
from beltsort.perception.clean import voxel_means
from beltsort.perception.level import BANDS, SAMPLES, levelled
from beltsort.perception.pose_fault import PoseCause
from beltsort.util.extras import extra

with extra("perception"):
    from scipy.spatial import Delaunay

PLANES = 3  # largest planes tried: a floor or a wall may be larger than the belt
LEAST_SHARE = 0.05  # of the points, on a plane
RANSAC_DISTANCE, RANSAC_ROUNDS = 0.008, 500  # metres
NEAREST, FARTHEST = 0.02, 20.0  # metres; plausible median distances from the camera

BELT_VOXEL, BELT_GAP = 0.02, 0.06  # metres
LOWEST, TALLEST = 0.015, 0.4  # metres above the belt, of the top of a mark
WIDEST = 0.3  # metres; larger clusters are parts of the machine
VOXEL, GAP = 0.004, 0.015  # metres
FEWEST_VOXELS = 60  # flying pixels behind an object make smaller clusters
TOP_QUANTILE, TOP_BAND = 0.95, 0.004  # metres about the height of the top
LEAST_DIFFERENCE = 0.015  # metres between the heights of marks in one scan


@dataclass(frozen=True, eq=False)
class Landmarks:
    """What one scan shows, camera frame, metres.

    Attributes
    ----------
    normal
        Normal of the belt, towards the camera, shape (3,).
    centre
        Mean of the points on the belt, shape (3,).
    marks
        Points of the belt under the tops of the marks, the tallest first, shape (k, 3).
    rms
        Root mean square distance of the points within 5 mm of the plane from it.
    share
        Share of all points within 5 mm of the plane.
    """

    normal: Points
    centre: Points
    marks: Points
    rms: float
    share: float

    def scaled(self, factors: Points) -> "Landmarks":
        """Return the landmarks with the camera's axes scaled, shape (3,), to mirror them for example."""
        return replace(
            self, normal=factors * self.normal, centre=factors * self.centre, marks=factors * self.marks
        )


def find_landmarks(points: Points, count: int) -> Landmarks:
    """Find the belt and the marks on it.

    Parameters
    ----------
    points
        Shape (n, 3), camera frame, metres; points that are not finite are ignored.
    count
        Number of marks on the belt.

    Raises
    ------
    CloudError
        If there is no plane, or not this number of marks stands on it.
    """
    points = points[np.isfinite(points).all(axis=1)]
    _check_metres(points)
    found = []
    for plane_from_camera in _planes(points):
        landmarks, heights = _on_plane(points, plane_from_camera)
        if count == 0 or len(heights) == count:
            _check_heights(heights[:count])
            return replace(landmarks, marks=landmarks.marks[:count])
        found.append(heights)
    if not found:
        raise CloudError(
            f"no plane contains {LEAST_SHARE:.0%} of the {len(points)} points, expected the belt's: bring it "
            "into view"
        )
    listed = ", ".join(f"{1000.0 * height:.0f}" for height in found[0])
    seen = f"{len(found[0])} objects ({listed} mm high)" if listed else "nothing"
    raise CloudError(
        f"on the largest plane there is {seen}, expected {count} marks: put objects from "
        f"{1000.0 * LOWEST:.0f} to {1000.0 * TALLEST:.0f} mm high there, in full "
        "view, and take all else off the belt"
    )


def _check_metres(points: Points) -> None:
    distance = float(np.median(np.linalg.norm(points, axis=1))) if len(points) else 0.0
    if not NEAREST <= distance <= FARTHEST:
        cause = PoseCause.POINTS_MM if distance > FARTHEST else PoseCause.POINTS_KM
        raise CloudError(
            f"the points' median distance is {distance:.3g}, expected {NEAREST:g} to {FARTHEST:g} metres; "
            f"likely: {cause}"
        )


def _check_heights(heights: NDArray[np.float64]) -> None:
    """Raise an error if marks cannot be told apart by their heights, metres, descending."""
    if len(heights) > 1 and (-np.diff(heights)).min() < LEAST_DIFFERENCE:
        listed = ", ".join(f"{1000.0 * height:.0f}" for height in heights)
        raise CloudError(
            f"the marks are {listed} mm high, expected differences of {1000.0 * LEAST_DIFFERENCE:.0f} mm, by "
            "which they are told apart: take other objects, or scan one at a time"
        )


def _planes(points: Points) -> Iterator[Pose]:
    """Yield `plane_from_camera` of the largest planes, with z the height above them, shape (4, 4) each."""
    with extra("perception"):
        import open3d as o3d

    rest = points[:: 1 + len(points) // SAMPLES]
    least = max(3, round(LEAST_SHARE * len(rest)))
    for _ in range(PLANES):
        if len(rest) < least:
            return
        o3d.utility.random.seed(0)
        cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(rest))
        plane, inside = cloud.segment_plane(RANSAC_DISTANCE, 3, RANSAC_ROUNDS)
        if len(inside) < least:
            return
        level = levelled(rest, _plane_frame(np.array(plane[:3]), rest[inside].mean(axis=0)))
        # The origin under the camera, so that the voxels do not depend on what RANSAC has drawn.
        yield _plane_frame(level[2, :3], -level[2, 3] * level[2, :3])
        rest = np.delete(rest, inside, axis=0)


def _plane_frame(normal: Points, centre: Points) -> Pose:
    """Return `plane_from_camera` of the plane through a point, z towards the camera, shape (4, 4)."""
    z = -np.sign(normal @ centre) * normal / np.linalg.norm(normal)
    x = np.cross(np.eye(3)[np.abs(z).argmin()], z)
    x /= np.linalg.norm(x)
    frame = np.eye(4)
    frame[:3, :3] = [x, np.cross(z, x), z]
    frame[:3, 3] = -frame[:3, :3] @ centre
    return frame


def _on_plane(points: Points, plane_from_camera: Pose) -> tuple[Landmarks, NDArray[np.float64]]:
    """Return what stands on a plane, and the heights of all marks, descending, metres."""
    camera_from_plane = inverse(plane_from_camera)
    local = transform(plane_from_camera, points)
    height = local[:, 2]
    on_plane = np.abs(height) < BANDS[-1]
    tops = _tops(local, local[on_plane])
    feet = np.column_stack([tops[:, :2], np.zeros(len(tops))])
    centre = np.append(local[on_plane, :2].mean(axis=0), 0.0)
    landmarks = Landmarks(
        normal=camera_from_plane[:3, 2],
        centre=transform(camera_from_plane, centre),
        marks=transform(camera_from_plane, feet),
        rms=float(np.sqrt((height[on_plane] ** 2).mean())),
        share=float(on_plane.mean()),
    )
    return landmarks, tops[:, 2]


def _tops(local: Points, on_plane: Points) -> Points:
    """Return the centroids of the tops of marks, the tallest first, plane's frame, shape (k, 3)."""
    belt = _largest(voxel_means(on_plane, BELT_VOXEL), BELT_GAP)
    if len(belt) < 4:
        return np.empty((0, 3))
    above = local[(local[:, 2] > LOWEST) & (local[:, 2] < TALLEST)]
    above = above[Delaunay(belt[:, :2]).find_simplex(above[:, :2]) >= 0]
    voxels = voxel_means(above, VOXEL)
    cluster = _core.clusters(voxels, GAP)
    tops = [
        _top(voxels[cluster == k])
        for k, size in enumerate(np.bincount(cluster))
        if size >= FEWEST_VOXELS and np.ptp(voxels[cluster == k], axis=0).max() < WIDEST
    ]
    return np.array(sorted(tops, key=lambda top: -top[2])).reshape(-1, 3)


def _largest(points: Points, gap: float) -> Points:
    """Return the largest cluster of points, shape (n, 3)."""
    cluster = _core.clusters(points, gap)
    largest: Points = points[cluster == np.bincount(cluster, minlength=1).argmax()]
    return largest


def _top(mark: Points) -> Points:
    """Return the centroid of the area of a mark's top, and its height, shape (3,).

    Of the area, not of the points: more of them are seen on the nearer half, and on the side below its edge.
    """
    height = float(np.quantile(mark[:, 2], TOP_QUANTILE))
    top = mark[np.abs(mark[:, 2] - height) < TOP_BAND]
    x, y, _ = voxel_means(top * [1.0, 1.0, 0.0], VOXEL).mean(axis=0)
    return np.array([x, y, height])
