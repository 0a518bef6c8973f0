"""Clouds as NumPy arrays: .npy files."""

from io import BytesIO
from math import prod
from typing import Any

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from beltsort.perception.formats.content import Content, UnreadableError, expect, left_over

HEADERS = {(1, 0): npy.read_array_header_1_0, (2, 0): npy.read_array_header_2_0}
FIELDS = (("x", "y", "z"), ("f0", "f1", "f2"))
"""Names of the coordinates in structured arrays; the second are those of pyrealsense2."""


def parse_npy(data: bytes) -> Content:
    """Return the points of a .npy file.

    Raises
    ------
    UnreadableError
        If it is damaged, or its array has no coordinates in its last axis.
    """
    shape, by_columns, dtype, start = _header(data)
    axes = _axes(dtype) if dtype.fields else ()
    if not axes:
        _check_plain(dtype, shape)
    body = data[start:]
    size = prod(shape) * dtype.itemsize
    expect(len(body), size, "bytes of data")
    values: NDArray[Any] = np.frombuffer(body, dtype, prod(shape))
    values = values.reshape(shape, order="F" if by_columns else "C")
    if axes:
        points = np.column_stack([values[axis].reshape(-1).astype(np.float64) for axis in axes])
    else:
        points = values[..., :3].reshape(-1, 3).astype(np.float64)
    return Content(points, notes=left_over(body[size:], "the array"))


def _header(data: bytes) -> tuple[tuple[int, ...], bool, np.dtype[np.generic], int]:
    """Return shape, whether columns come first, type, and where the values start."""
    stream = BytesIO(data)
    try:
        shape, by_columns, dtype = HEADERS[npy.read_magic(stream)](stream)
    except Exception as reason:  # damaged headers raise whatever Python's own parser does
        raise UnreadableError("its header is not that of a NumPy array") from reason
    if min(shape, default=0) < 0:
        raise UnreadableError(f"the array has the shape {shape}")
    return shape, by_columns, dtype, stream.tell()


def _axes(dtype: np.dtype[np.generic]) -> tuple[str, ...]:
    """Return the names of the coordinates among a structured array's fields."""
    fields = {name: field[0] for name, field in (dtype.fields or {}).items()}
    axes = next((names for names in FIELDS if set(names) <= set(fields)), ())
    if not axes or any(fields[axis].kind not in "fiu" for axis in axes):
        raise UnreadableError(
            f"the array has the fields {[*fields]}, expected numbers x, y, z (or f0, f1, f2) among them",
            remedy="save an array of shape (n, 3)",
        )
    return axes


def _check_plain(dtype: np.dtype[np.generic], shape: tuple[int, ...]) -> None:
    holds = f"the array holds {dtype} in shape {shape}, expected numbers in shape (..., 3) or (..., 4)"
    if dtype.kind not in "fiu":
        raise UnreadableError(holds, remedy="save the coordinates as numbers")
    if len(shape) > 1 and shape[-1] in (3, 4):
        return
    if shape == (3,):
        return
    if len(shape) > 1 and shape[0] in (3, 4):
        order = "points.T" if len(shape) == 2 else "np.moveaxis(points, 0, -1)"
        raise UnreadableError(holds, remedy=f"x, y and z come first: save np.ascontiguousarray({order})")
    if len(shape) == 2 and shape[1] > 4 and shape[1] <= 16:
        raise UnreadableError(holds, remedy="save the columns x, y and z only: points[:, :3], say")
    if len(shape) == 2 and shape[1] > 16:
        raise UnreadableError(
            holds,
            remedy="if it is a depth image, save what beltsort.perception.cloud_from_depth makes of it",
        )
    raise UnreadableError(holds, remedy="save an array of shape (n, 3)")
