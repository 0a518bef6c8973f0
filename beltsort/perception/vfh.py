"""The viewpoint feature histogram."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from beltsort import _core
from beltsort.errors import CloudError
from beltsort.geometry import Points
from beltsort.perception.checks import as_array

FEWEST_POINTS = 3
LENGTH = _core.VFH_BINS

Histogram = NDArray[np.float64]


def vfh(
    points: ArrayLike,
    normals: ArrayLike,
    *,
    viewpoint: ArrayLike = (0, 0, 0),
    size_component: bool = True,
    normalize_distance: bool = False,
    raw_counts: bool = False,
    pcl_compatible: bool = False,
) -> Histogram:
    r"""Return the viewpoint feature histogram of one cloud, shape (308,).

    With the centroid :math:`c`, the mean normal :math:`\bar n`, and for each point :math:`p_i` with normal
    :math:`n_i`, :math:`d = p_i - c`: :math:`u` is whichever of :math:`\bar n` and :math:`n_i` lies nearer to
    the line along :math:`d`, :math:`m` is the other (:math:`d` points to its side), and
    :math:`v = d \times u / |d \times u|`, :math:`w = u \times v`.

    ======== =================================================== ====================
    bins     feature                                             range
    ======== =================================================== ====================
    0-44     :math:`\theta = \arctan(w \cdot m, u \cdot m)`      :math:`[-\pi, \pi]`
    45-89    :math:`\cos\alpha = v \cdot m`                      :math:`[-\pi, \pi]`
    90-134   :math:`\cos\phi = u \cdot d / |d|`                  :math:`[-\pi, \pi]`
    135-179  :math:`|d|` (zero without the size component)       centimetres
    180-307  :math:`n_i \cdot (viewpoint - c) / |viewpoint - c|` :math:`[-1, 1]`
    ======== =================================================== ====================

    A point without such a frame (at the centroid, or :math:`d` parallel to :math:`u`) counts in the last
    block only. A rigid motion of points, normals and viewpoint together changes nothing, so descriptors from
    different places are comparable.

    Parameters
    ----------
    points
        Shape (n, 3), metres, finite, at least three.
    normals
        Unit normals, shape (n, 3).
    viewpoint
        Position of the camera in the frame of the points, shape (3,), metres.
    size_component
        Fill bins 135-179.
    normalize_distance
        Divide the distances of bins 135-179 by the largest, so that only their ratios count.
    raw_counts
        Count points instead of percent.
    pcl_compatible
        Reproduce PCL 1.13, whose viewpoint block and normalised distances depend on the unit of length (the
        homogeneous 1 of the centroid enters both norms).

    Raises
    ------
    CloudError
        If the shapes do not fit, a value is no finite number, there are fewer than three points, or
        the viewpoint is the centroid.

    References
    ----------
    R. B. Rusu, G. Bradski, R. Thibaux, J. Hsu, "Fast 3D recognition and pose using the viewpoint feature
    histogram", IROS 2010, section III.

    Examples
    --------
    A flat square, seen from above: all normals point at the camera.

    >>> import numpy as np
    >>> square = np.array([[x, y, 0.0] for x in (0.0, 0.1, 0.2) for y in (0.0, 0.1, 0.2)])
    >>> histogram = vfh(square, np.tile([0.0, 0.0, 1.0], (9, 1)), viewpoint=(0.1, 0.1, 1.0))
    >>> float(histogram[307]), float(histogram[180:].sum())
    (100.0, 100.0)
    """
    cloud, eye = checked_view(points, viewpoint)
    histogram = _core.vfh(
        cloud,
        _finite("normals", normals, cloud.shape),
        eye,
        size_component=size_component,
        normalize_distance=normalize_distance,
        raw_counts=raw_counts,
        pcl_compatible=pcl_compatible,
    )
    if histogram is None:
        raise CloudError(
            "the viewpoint is the centroid of the cloud, so no viewing direction exists: "
            "give the camera's position in the frame of the points"
        )
    return histogram


def vfh_batch(
    clouds: Sequence[ArrayLike],
    normals: Sequence[ArrayLike],
    viewpoints: Sequence[ArrayLike],
    **settings: bool,
) -> Histogram:
    """Return the viewpoint feature histograms of many clouds, shape (m, 308).

    Parameters
    ----------
    clouds, normals, viewpoints
        The arguments of `vfh` for each cloud, m of each.
    **settings
        Keywords of `vfh`, the same for all.

    Raises
    ------
    CloudError
        If the numbers differ, or `vfh` raises for a cloud; a note of the error names the cloud.
    """
    if not len(clouds) == len(normals) == len(viewpoints):
        raise CloudError(
            f"{len(clouds)} clouds, {len(normals)} arrays of normals and {len(viewpoints)} viewpoints, "
            "expected as many of each: give every cloud its own"
        )
    rows = np.empty((len(clouds), LENGTH))
    for number, (points, directions, viewpoint) in enumerate(zip(clouds, normals, viewpoints, strict=True)):
        try:
            rows[number] = vfh(points, directions, viewpoint=viewpoint, **settings)
        except CloudError as refused:
            refused.add_note(f"cloud {number} of {len(clouds)}")
            raise
    return rows


def checked_view(points: ArrayLike, viewpoint: ArrayLike) -> tuple[Points, Points]:
    """Return a cloud, shape (n, 3), and the camera's position, shape (3,), both finite.

    Raises
    ------
    CloudError
        If the shapes do not fit, a value is no finite number, or there are fewer than three points.
    """
    cloud, eye = _finite("points", points, (-1, 3)), _finite("viewpoint", viewpoint, (3,))
    if len(cloud) < FEWEST_POINTS:
        raise CloudError(
            f"the cloud has {len(cloud)} points, expected at least {FEWEST_POINTS}: "
            "skip it or scan from closer"
        )
    return cloud, eye


def _finite(name: str, given: ArrayLike, shape: tuple[int, ...]) -> Points:
    """Return `given` as a finite array of `shape`, of any length where `shape` says -1."""
    values: Points = as_array(name, given, CloudError)
    if values.ndim != len(shape) or any(m not in (-1, n) for n, m in zip(values.shape, shape, strict=True)):
        expected = str(shape).replace("-1", "n")
        raise CloudError(
            f"{name} have shape {values.shape}, expected {expected}: give points of shape (n, 3), one unit "
            "normal for each of them, and one position of the camera"
        )
    bad = int((~np.isfinite(values)).sum())
    if bad > 0:
        raise CloudError(
            f"{name} hold {bad} values that are NaN or infinite, expected finite ones: "
            "drop those points (points[np.isfinite(points).all(axis=-1)])"
        )
    return np.ascontiguousarray(values)
