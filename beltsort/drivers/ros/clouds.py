"""Decoding of `sensor_msgs/PointCloud2`."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from beltsort.errors import CellError
from beltsort.geometry import Points

FLOAT32 = 7
TYPES = {FLOAT32: "f4", 8: "f8"}
"""NumPy types of coordinates, by PointField's type number."""


@dataclass(frozen=True)
class Cloud:
    """A PointCloud2 without its header.

    Attributes
    ----------
    height, width
        Rows and columns of the depth image; one row if the cloud is not organised.
    fields
        Offset within a point (bytes) and PointField's type number, by name.
    big_endian
        Byte order of the coordinates.
    point_step, row_step
        Bytes from a point to the next one, and from a row to the next one; `row_step` may be 0 for one row.
    data
        The rows.
    """

    height: int
    width: int
    fields: Mapping[str, tuple[int, int]]
    big_endian: bool
    point_step: int
    row_step: int
    data: bytes | memoryview


def packed(points: Points) -> Cloud:
    """Return points, shape (height, width, 3) or (n, 3), as a cloud of float32 coordinates."""
    rows = points if points.ndim == 3 else points[None]
    height, width = rows.shape[:2]
    fields = {name: (4 * i, FLOAT32) for i, name in enumerate("xyz")}
    return Cloud(height, width, fields, False, 12, 12 * width, rows.astype("<f4").tobytes())


def points_of(cloud: Cloud) -> Points:
    """Read the points of a cloud.

    Returns
    -------
    Points
        Shape (height, width, 3), or (width, 3) for a single row. NaN is kept; a point at the origin, which
        some drivers publish where there is no return, becomes NaN.

    Raises
    ------
    CellError
        If the cloud has no points, no finite point, too little data, or no coordinates.

    Examples
    --------
    >>> import numpy as np
    >>> points_of(packed(np.array([[0.0, 0.5, 1.0], [np.nan, 0.0, 1.0]])))
    array([[0. , 0.5, 1. ],
           [nan, 0. , 1. ]])
    """
    _check(cloud)
    order = ">" if cloud.big_endian else "<"
    record = np.dtype(
        {
            "names": ["x", "y", "z"],
            "formats": [order + TYPES[cloud.fields[name][1]] for name in "xyz"],
            "offsets": [cloud.fields[name][0] for name in "xyz"],
            "itemsize": cloud.point_step,
        }
    )
    strides = (cloud.row_step or cloud.width * cloud.point_step, cloud.point_step)
    rows: np.ndarray[tuple[int, ...], np.dtype[np.void]] = np.ndarray(
        (cloud.height, cloud.width), record, cloud.data, strides=strides
    )
    points = np.stack([rows[name].astype(np.float64) for name in "xyz"], axis=-1)
    points[(points == 0.0).all(axis=-1)] = np.nan
    if not np.isfinite(points).all(axis=-1).any():
        raise CellError(
            f"none of the {cloud.height * cloud.width} points is finite and away from the camera, expected "
            "some returns; check what is in front of the camera, and its distance"
        )
    return points if cloud.height > 1 else points[0]


def _check(cloud: Cloud) -> None:
    if cloud.height < 1 or cloud.width < 1:
        raise CellError(
            f"the cloud is empty ({cloud.height} x {cloud.width} points), expected points; check the camera"
        )
    for name in "xyz":
        offset, kind = cloud.fields.get(name, (-1, 0))
        size = np.dtype(TYPES[kind]).itemsize if kind in TYPES else 0
        if size == 0 or not 0 <= offset <= cloud.point_step - size:
            raise CellError(
                f"the cloud has no usable field {name!r} (fields {dict(cloud.fields)}, {cloud.point_step} "
                "bytes a point), expected x, y and z as float32 (7) or float64 (8); take a cloud with points"
            )
    row = cloud.width * cloud.point_step
    if cloud.row_step < row and not (cloud.height == 1 and cloud.row_step == 0):
        raise CellError(
            f"the cloud's row_step is {cloud.row_step}, expected at least {row} ({cloud.width} points of "
            f"{cloud.point_step} bytes); correct its publisher"
        )
    needed = (cloud.height - 1) * cloud.row_step + row
    if len(cloud.data) < needed:
        raise CellError(
            f"the cloud is truncated: {len(cloud.data)} bytes in rows of {cloud.row_step}, expected {needed} "
            f"for {cloud.height} x {cloud.width} points of {cloud.point_step} bytes; look at its publisher"
        )
