"""Point clouds from files."""

from collections.abc import Callable
from io import BytesIO
from math import prod
from os import PathLike
from pathlib import Path

import numpy as np
from numpy.lib import format as npy

from beltsort.errors import CloudError
from beltsort.geometry import Points
from beltsort.perception.records import expect, parse_pcd, parse_ply

NPY_HEADERS = {(1, 0): npy.read_array_header_1_0, (2, 0): npy.read_array_header_2_0}


def read_cloud(path: str | PathLike[str]) -> Points:
    """Read a point cloud.

    Parameters
    ----------
    path
        A .pcd, .ply, .xyz (text, one point a line) or .npy file (last axis of length 3).

    Returns
    -------
    Points
        Shape (n, 3), n > 0, in the file's unit and frame; NaN where the file has NaN.

    Raises
    ------
    CloudError
        If the file is missing, of another format, damaged, truncated, or holds no point.
    """
    file = Path(path)
    parse = PARSERS.get(file.suffix.lower())
    if parse is None:
        raise CloudError(
            f"{file} has suffix {file.suffix!r}, expected one of {sorted(PARSERS)}: convert the file"
        )
    try:
        points = parse(file.read_bytes())
    except Exception as reason:  # whatever a parser stumbles over means that the file is damaged
        raise CloudError(
            f"cannot read {file}: {reason}; expected a complete {file.suffix} file: write it again"
        ) from reason
    if len(points) == 0:
        raise CloudError(f"{file} holds 0 points, expected at least one: scan again")
    return points


def _parse_xyz(data: bytes) -> Points:
    if not any(line.split(b"#")[0].strip() for line in BytesIO(data)):
        return np.empty((0, 3))
    columns: Points = np.loadtxt(BytesIO(data), ndmin=2, encoding="utf-8")
    if columns.shape[1] < 3:
        raise ValueError(f"{columns.shape[1]} columns")
    return columns[:, :3]


def _parse_npy(data: bytes) -> Points:
    stream = BytesIO(data)
    shape, by_columns, dtype = NPY_HEADERS[npy.read_magic(stream)](stream)
    if dtype.kind not in "fiu" or shape[-1:] != (3,) or min(shape) < 0:
        raise ValueError(f"the array holds {dtype} in shape {shape}")
    body = data[stream.tell() :]
    expect(len(body), prod(shape) * dtype.itemsize, "bytes")
    values = np.frombuffer(body, dtype, prod(shape)).reshape(shape, order="F" if by_columns else "C")
    points: Points = values.reshape(-1, 3).astype(np.float64)
    return points


PARSERS: dict[str, Callable[[bytes], Points]] = {
    ".pcd": parse_pcd,
    ".ply": parse_ply,
    ".xyz": _parse_xyz,
    ".npy": _parse_npy,
}
