import numpy as np
from numpy.typing import NDArray

def vfh(
    points: NDArray[np.float64],
    normals: NDArray[np.float64],
    viewpoint: NDArray[np.float64],
    *,
    size_component: bool,
    normalize_distance: bool,
    raw_counts: bool,
    pcl_compatible: bool,
) -> NDArray[np.float64] | None:
    """Return the viewpoint feature histogram, or None where the viewpoint is the centroid.

    Parameters
    ----------
    points, normals : ndarray
        Contiguous, finite, shape (n, 3) both.
    viewpoint : ndarray
        Shape (3,).
    size_component, normalize_distance, raw_counts, pcl_compatible : bool
        As in `beltsort.perception.vfh`.
    """

def lzf_decompress(data: bytes, size: int) -> bytes | None:
    """Return the `size` bytes that `data` holds compressed by LZF, or None if it does not hold just those."""

def clusters(points: NDArray[np.float64], gap: float) -> NDArray[np.uintp]:
    """Return the number of each point's cluster, from 0; steps no longer than `gap` join its points.

    Parameters
    ----------
    points : ndarray
        Contiguous, finite, shape (n, 3).
    gap : float
        In the unit of the points.
    """
