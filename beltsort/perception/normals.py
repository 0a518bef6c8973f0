"""Surface normals that face the camera."""

import numpy as np
from numpy.typing import ArrayLike

from beltsort.geometry import Points
from beltsort.perception.vfh import checked_view


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
