"""The descriptor of a candidate: a VFH of its points and of normals estimated from them, and its size."""

import numpy as np
from numpy.typing import ArrayLike

from beltsort.geometry import Points
from beltsort.perception.checks import warn_unless_metres
from beltsort.perception.config import PerceptionConfig
from beltsort.perception.size import SIZES, size_features
from beltsort.perception.vfh import LENGTH, Histogram, checked_view, vfh
from beltsort.util.extras import extra

PLAUSIBLE_EXTENTS = (0.001, 5.0)  # metres

SIZE_WEIGHT = 10_000.0
"""What a metre of size adds to the descriptor, where 100 is all points of a block of the histogram.

Chosen by leave-one-out classification of the training objects of the simulated cell. Any value from 5,000 to
20,000 is about as good.
"""

LONGEST = LENGTH + SIZES
"""Length of the longest descriptor."""


def length_of(config: PerceptionConfig) -> int:
    """Return the length of a descriptor that `describe` returns."""
    return LONGEST if config.descriptor == "vfh+size" else LENGTH


def describe(points: ArrayLike, camera: ArrayLike, config: PerceptionConfig | None = None) -> Histogram:
    """Return the descriptor of a candidate, shape (308,), or with its size shape (311,).

    The lengths of `size_features` are multiplied by `SIZE_WEIGHT`, so that distances of histograms count
    them too.

    Parameters
    ----------
    points
        Shape (n, 3), metres; in the belt frame if the size is part of the descriptor.
    camera
        The camera's position in the same frame, shape (3,).
    config
        Settings; default `PerceptionConfig()`.

    Raises
    ------
    CloudError
        If the shapes do not fit, a value is no finite number, there are fewer than three points, or
        the camera is their centroid; with the size also as `size_features`.

    Warns
    -----
    UnitWarning
        If no object that a robot picks is of that extent in metres.
    """
    config = config or PerceptionConfig()
    cloud, _ = checked_view(points, camera)
    warn_unless_metres("the cloud's extent", float(np.ptp(cloud, axis=0).max()), PLAUSIBLE_EXTENTS)
    normals = oriented_normals(points, camera, config.normal_neighbours)
    histogram = vfh(points, normals, viewpoint=camera, size_component=config.size_component)
    if config.descriptor == "vfh":
        return histogram
    return np.concatenate([histogram, SIZE_WEIGHT * size_features(points, camera)])


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
    with extra("perception"):
        import open3d as o3d

    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(seen))
    cloud.estimate_normals(o3d.geometry.KDTreeSearchParamKNN(neighbours))
    normals: Points = np.array(cloud.normals)
    away = np.einsum("ij,ij->i", normals, eye - seen) < 0.0
    normals[away] *= -1.0
    return normals
