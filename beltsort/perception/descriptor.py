"""The descriptor of a candidate."""

from numpy.typing import ArrayLike

from beltsort.perception.config import PerceptionConfig
from beltsort.perception.normals import oriented_normals
from beltsort.perception.vfh import Histogram, vfh


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
    """
    config = config or PerceptionConfig()
    normals = oriented_normals(points, camera, config.normal_neighbours)
    return vfh(points, normals, viewpoint=camera, size_component=config.size_component)
