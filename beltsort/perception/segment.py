"""From a scan to one cleaned cloud per belt position."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from beltsort.errors import CloudError
from beltsort.geometry import BeltLayout, Points, Pose, transform
from beltsort.perception.checks import as_array
from beltsort.perception.config import PerceptionConfig
from beltsort.perception.level import levelled


class DepthScan(Protocol):
    """What segmentation needs to know of a scan."""

    @property
    def points(self) -> Points:
        """Camera frame, metres, shape (height, width, 3) or (n, 3); NaN where nothing returned."""

    @property
    def world_from_camera(self) -> Pose:
        """The camera's reported pose, shape (4, 4)."""


@dataclass(frozen=True)
class Segmented:
    """What a scan shows of each belt position.

    Attributes
    ----------
    candidates
        For each position the object's points above the rim, shape (n, 3), world frame, metres, or None where
        the position is empty.
    camera
        The camera's position after correction by the seen belt, shape (3,), world frame, metres.
    """

    candidates: tuple[Points | None, ...]
    camera: Points


def segment(scan: DepthScan, layout: BeltLayout, config: PerceptionConfig | None = None) -> Segmented:
    """Cut a scan into one candidate per belt position.

    Scan -> world frame corrected by the seen belt -> upright cylinder above each rim -> voxels -> no outliers
    -> main clusters. The same scan always gives the same result.

    Parameters
    ----------
    scan
        Points in the camera frame, metres, and the camera's pose.
    layout
        Where the objects stand.
    config
        Settings; default `PerceptionConfig()`.

    Raises
    ------
    CloudError
        If the scan has another shape, its pose is not finite, or no point of it is.
    """
    config = config or PerceptionConfig()
    points = _checked(scan)
    world_from_camera = levelled(points, scan.world_from_camera)
    above = _above_rims(points, world_from_camera, layout, config)
    candidates = tuple(_candidate(above, layout, position, config) for position in range(layout.positions))
    return Segmented(candidates, world_from_camera[:3, 3].copy())


def _checked(scan: DepthScan) -> Points:
    points = as_array("the scan's points", scan.points, CloudError)
    pose = as_array("world_from_camera", scan.world_from_camera, CloudError)
    if points.ndim not in (2, 3) or points.shape[-1] != 3:
        raise CloudError(
            f"the scan's points have shape {points.shape}, expected (height, width, 3) or (n, 3): "
            "give coordinates in metres, not a depth image"
        )
    if pose.shape != (4, 4) or not np.isfinite(pose).all():
        raise CloudError(
            f"world_from_camera is {pose.tolist()}, expected a finite (4, 4) transform: check the arm"
        )
    return points.reshape(-1, 3)


def _above_rims(
    points: Points, world_from_camera: Pose, layout: BeltLayout, config: PerceptionConfig
) -> Points:
    """Return the points between rim and top of the crop, world frame; what is not finite never passes."""
    with np.errstate(invalid="ignore"):
        # Not `@`: threads of BLAS cost more than they gain where other threads are busy.
        height = np.einsum("ij,j->i", points, world_from_camera[2, :3]) + world_from_camera[2, 3]
        if not np.isfinite(height).any():
            raise CloudError(
                f"none of {len(points)} points in the scan is finite, expected the belt's: check the camera"
            )
        inside = (height > layout.rim_height + config.rim_clearance) & (height < layout.crop_height)
    return transform(world_from_camera, points[inside])


def _candidate(above: Points, layout: BeltLayout, position: int, config: PerceptionConfig) -> Points | None:
    from_axis = above[:, :2] - layout.centre(position)[:2]
    cropped = above[(from_axis**2).sum(axis=1) < layout.crop_radius**2]
    voxels = voxel_means(cropped, config.voxel)
    if len(voxels) < config.fewest_seen:
        return None
    return _main_clusters(_without_outliers(voxels, config), config)


def voxel_means(points: Points, voxel: float) -> Points:
    """Return the mean point of each occupied cube of edge `voxel`, shape (m, 3), in the cubes' order."""
    if len(points) == 0:
        return points
    cells = np.floor(points / voxel).astype(np.int64)
    cells -= cells.min(axis=0)
    extent = cells.max(axis=0) + 1
    key = (cells[:, 0] * extent[1] + cells[:, 1]) * extent[2] + cells[:, 2]
    _, voxel_of, count = np.unique(key, return_inverse=True, return_counts=True)
    sums = np.column_stack([np.bincount(voxel_of, weights=points[:, axis]) for axis in range(3)])
    means: Points = sums / count[:, None]
    return means


def _without_outliers(points: Points, config: PerceptionConfig) -> Points:
    import open3d as o3d

    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points))
    _, kept = cloud.remove_statistical_outlier(config.outlier_neighbours, config.outlier_ratio)
    return points[np.asarray(kept, dtype=np.intp)]


def _main_clusters(points: Points, config: PerceptionConfig) -> Points | None:
    import open3d as o3d

    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points))
    cluster: NDArray[np.int32] = np.asarray(cloud.cluster_dbscan(config.cluster_gap, min_points=1))
    sizes = np.bincount(cluster)
    if sizes.max(initial=0) < config.fewest_seen:
        return None
    kept: Points = points[(sizes >= config.cluster_share * sizes.max())[cluster]]
    return kept
