"""The descriptor of a candidate: a VFH of its points and of normals estimated from them."""

import numpy as np
from numpy.typing import ArrayLike

from beltsort.geometry import Points
from beltsort.perception.checks import warn_unless_metres
from beltsort.perception.config import PerceptionConfig
from beltsort.perception.vfh import Histogram, checked_view, vfh

PLAUSIBLE_EXTENTS = (0.001, 5.0)  # metres


def describe(points: ArrayLike, camera: ArrayLike, config: PerceptionConfig | None = None) -> Histogram:
    """Return the descriptor of a candidate, shape (308,).

    Parameters
    ----------
    points
        Shape (n, 3), metres.
    camera
        The camera's position in the same frame, shape (3,).
    config
        Settings; default `PerceptionConfig()`.

    Raises
    ------
    CloudError
        If the shapes do not fit, a value is no finite number, there are fewer than three points, or
        the camera is their centroid.

    Warns
    -----
    UnitWarning
        If no object that a robot picks is of that extent in metres.
    """
    config = config or PerceptionConfig()
    cloud, _ = checked_view(points, camera)
    warn_unless_metres("the cloud's extent", float(np.ptp(cloud, axis=0).max()), PLAUSIBLE_EXTENTS)
    normals = oriented_normals(points, camera, config.normal_neighbours)
    return vfh(points, normals, viewpoint=camera, size_component=config.size_component)


def oriented_normals(points: ArrayLike, viewpoint: ArrayLike, neighbours: int) -> Points:
    """Return unit normals, each on the side of its surface from which the camera looks, shape (n, 3).

    Parameters
    ----------
    points
        Shape (n, 3), finite, metres.
    viewpoint
        The camera's position in the frame of the points, shape (3,).
    neighbours
        A normal is the direction of least spread among so many nearest points, the point itself included.

    Raises
    ------
    CloudError
        If the shapes do not fit, a value is no finite number, or there are fewer than three points.
    """
    seen, eye = checked_view(points, viewpoint)
    import open3d as o3d

    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(seen))
    cloud.estimate_normals(o3d.geometry.KDTreeSearchParamKNN(neighbours))
    normals: Points = np.array(cloud.normals)
    away = np.einsum("ij,ij->i", normals, eye - seen) < 0.0
    normals[away] *= -1.0
    return normals
