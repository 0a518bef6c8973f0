"""Voxel averages, outlier removal and clustering of the points of one object."""

import numpy as np

from beltsort import _core
from beltsort.geometry import Points
from beltsort.perception.config import PerceptionConfig
from beltsort.util.extras import extra


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


def without_outliers(points: Points, config: PerceptionConfig) -> Points:
    """Return the points without statistical outliers (see `PerceptionConfig`), shape (m, 3)."""
    with extra("perception"):
        import open3d as o3d

    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points))
    _, kept = cloud.remove_statistical_outlier(config.outlier_neighbours, config.outlier_ratio)
    return points[np.asarray(kept, dtype=np.intp)]


def main_clusters(points: Points, config: PerceptionConfig) -> Points:
    """Return the largest cluster and those not much smaller, shape (m, 3); m = 0 if all are too small."""
    cluster = _core.clusters(points, config.cluster_gap)
    sizes = np.bincount(cluster, minlength=1)
    if sizes.max() < config.fewest_seen:
        return points[:0]
    kept: Points = points[(sizes >= config.cluster_share * sizes.max())[cluster]]
    return kept
