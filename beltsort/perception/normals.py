"""Surface normals that face the camera."""

import numpy as np

from beltsort.errors import CloudError
from beltsort.geometry import Points
from beltsort.perception.vfh import FEWEST_POINTS


def oriented_normals(points: Points, viewpoint: Points, neighbours: int) -> Points:
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
        If there are fewer than three points or one is not finite.
    """
    if len(points) < FEWEST_POINTS or not np.isfinite(points).all():
        raise CloudError(
            f"of the cloud's {len(points)} points {int(np.isfinite(points).all(axis=1).sum())} are finite; "
            f"normals need at least {FEWEST_POINTS}, all finite: drop the others or scan again"
        )
    import open3d as o3d

    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points))
    cloud.estimate_normals(o3d.geometry.KDTreeSearchParamKNN(neighbours))
    normals: Points = np.array(cloud.normals)
    away = np.einsum("ij,ij->i", normals, viewpoint - points) < 0.0
    normals[away] *= -1.0
    return normals
