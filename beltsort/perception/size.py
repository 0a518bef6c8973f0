"""The size of a candidate in the belt frame, which no histogram of angles tells."""

import numpy as np
from numpy.typing import ArrayLike

from beltsort.errors import CloudError
from beltsort.geometry import Points
from beltsort.perception.vfh import checked_view

SIZES = 3
"""Number of lengths that `size_features` returns."""


def size_features(points: ArrayLike, camera: ArrayLike) -> Points:
    """Return the height of a candidate's top and its two horizontal extents, shape (3,), metres.

    The first is the largest z, the height above the belt. The others are the extents along the horizontal
    axes of largest and smallest variance. A motion along the belt and a rotation about the vertical axis
    change none of them, unless the two variances are equal, so that any two axes are as good.

    Parameters
    ----------
    points
        Shape (n, 3), belt frame (z up, 0 on the belt), metres.
    camera
        The camera's position in the same frame, shape (3,).

    Raises
    ------
    CloudError
        If the shapes do not fit, a value is no finite number, there are fewer than three points, or
        the camera or the top is not above the belt: then the frame is another one.

    Examples
    --------
    A box of 0.1 m by 0.04 m whose top is 0.12 m above the belt.

    >>> box = np.array([[x, y, z] for x in (0.0, 0.1) for y in (0.3, 0.34) for z in (0.05, 0.12)])
    >>> size_features(box, (0.0, 0.0, 0.7)).round(3).tolist()
    [0.12, 0.1, 0.04]
    """
    cloud, eye = checked_view(points, camera)
    top = float(cloud[:, 2].max())
    if eye[2] <= 0.0 or top <= 0.0:
        raise CloudError(
            f"the camera is at z = {eye[2]:.4g} m and the top of the object at {top:.4g} m, expected both "
            "above the belt, z = 0: give points and camera in the belt frame, or use the descriptor 'vfh'"
        )
    horizontal = cloud[:, :2] - cloud[:, :2].mean(axis=0)
    _, axes = np.linalg.eigh(np.einsum("ni,nj->ij", horizontal, horizontal))
    short, long = np.ptp(np.einsum("ni,ij->nj", horizontal, axes), axis=0)
    return np.array([top, long, short])
