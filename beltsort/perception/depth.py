"""Points from depth images."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from beltsort.errors import CloudError
from beltsort.geometry import Points
from beltsort.perception.checks import as_array

MILLIMETRES = 1000.0
"""Units of depth per metre, the default: RealSense, Orbbec and Azure Kinect write millimetres."""


@dataclass(frozen=True)
class Intrinsics:
    """Intrinsics of a pinhole camera without distortion.

    Attributes
    ----------
    fx, fy
        Focal lengths, pixels.
    cx, cy
        Principal point, pixels; the centre of the first pixel is (0, 0).
    """

    fx: float
    fy: float
    cx: float
    cy: float

    def __post_init__(self) -> None:
        """Refuse focal lengths that are not positive."""
        values = (self.fx, self.fy, self.cx, self.cy)
        if not np.isfinite(values).all() or min(self.fx, self.fy) <= 0.0:
            raise CloudError(
                f"the intrinsics are fx, fy, cx, cy = {values}, expected finite numbers, fx and fy above 0: "
                "give those of the depth camera, in pixels"
            )

    @classmethod
    def of(cls, given: "Intrinsics | ArrayLike") -> "Intrinsics":
        """Return intrinsics given as such or as the camera matrix, shape (3, 3).

        Raises
        ------
        CloudError
            If it is neither.
        """
        if isinstance(given, Intrinsics):
            return given
        matrix = as_array("intrinsics", given, CloudError)
        if matrix.shape != (3, 3) or not np.array_equal(matrix[2], [0.0, 0.0, 1.0]):
            raise CloudError(
                f"the camera matrix is {matrix.tolist()}, expected shape (3, 3) with the last row 0, 0, 1: "
                "give [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]"
            )
        return cls(*(float(matrix[at]) for at in ((0, 0), (1, 1), (0, 2), (1, 2))))


def cloud_from_depth(
    depth: ArrayLike, intrinsics: Intrinsics | ArrayLike, scale: float = MILLIMETRES
) -> Points:
    """Return the points of a depth image.

    Parameters
    ----------
    depth
        Shape (h, w): distance along the optical axis at each pixel, in units of 1 / `scale` metres. 0, NaN
        and negative or infinite values are pixels without return.
    intrinsics
        Of the depth camera, as `Intrinsics` or as the camera matrix, shape (3, 3), pixels.
    scale
        Units of depth per metre: 1000 for millimetres, 5000 for the TUM RGB-D data set, 1 for metres.

    Returns
    -------
    Points
        Shape (h, w, 3), metres, camera frame (x right, y down, z forward); NaN where there is no return.

    Raises
    ------
    CloudError
        If a shape does not fit, or a number is not positive.

    Examples
    --------
    >>> camera = Intrinsics(fx=100.0, fy=100.0, cx=0.0, cy=0.0)
    >>> cloud_from_depth([[500, 0], [0, 600]], camera)[1, 1]
    array([0.006, 0.006, 0.6  ])
    """
    image = as_array("depth", depth, CloudError)
    if image.ndim != 2:
        raise CloudError(f"the depth image has shape {image.shape}, expected (h, w): give one value a pixel")
    if not (np.isfinite(scale) and scale > 0.0):
        raise CloudError(f"scale is {scale}, expected a number above 0: give the units of depth per metre")
    camera = Intrinsics.of(intrinsics)
    z = np.where(np.isfinite(image) & (image > 0.0), image, np.nan) / scale
    rows, columns = np.ogrid[: image.shape[0], : image.shape[1]]
    points: Points = np.stack(
        [(columns - camera.cx) * z / camera.fx, (rows - camera.cy) * z / camera.fy, z], axis=-1
    )
    return points
