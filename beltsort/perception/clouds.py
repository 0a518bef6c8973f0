"""Point clouds from files.

PCD and PLY are read here and not by Open3D, which fills up truncated text and PLY files with zeros or
uninitialised memory and only prints a warning. Open3D decompresses `binary_compressed` PCD, whose truncation
it detects.
"""

from collections.abc import Callable
from dataclasses import dataclass
from io import BytesIO
from os import PathLike
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from beltsort.errors import CloudError
from beltsort.geometry import Points

PCD_TYPES = {"F": "f", "I": "i", "U": "u"}
PLY_TYPES = {
    **{"char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4"},
    **{"int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4"},
    **{"float": "f4", "double": "f8", "float32": "f4", "float64": "f8"},
}
PLY_ORDERS = {"ascii": "<", "binary_little_endian": "<", "binary_big_endian": ">"}


@dataclass(frozen=True)
class Table:
    """What a header promises: `count` records of `record`, as text or as bytes, at the start of `body`."""

    record: np.dtype[np.void]
    count: int
    text: bool
    body: bytes


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
    reader = READERS.get(file.suffix.lower())
    if reader is None:
        raise CloudError(
            f"{file} has suffix {file.suffix!r}, expected one of {sorted(READERS)}: convert the file"
        )
    try:
        points = reader(file)
    except Exception as reason:  # whatever a parser stumbles over means that the file is damaged
        raise CloudError(
            f"cannot read {file}: {reason}; expected a complete {file.suffix} file: write it again"
        ) from reason
    if len(points) == 0:
        raise CloudError(f"{file} holds 0 points, expected at least one: scan again")
    return points


def _read_pcd(file: Path) -> Points:
    data = file.read_bytes()
    header, body = _split_header(data, b"DATA")
    fields = {words[0]: words[1:] for words in header}
    encoding = fields["DATA"][0]
    if encoding == "binary_compressed":
        return _decompress(file, int(fields["POINTS"][0]))
    if encoding not in ("ascii", "binary"):
        raise ValueError(f"DATA is {encoding!r}, expected ascii, binary or binary_compressed")
    counts = fields.get("COUNT", ["1"] * len(fields["FIELDS"]))
    columns = zip(fields["FIELDS"], fields["TYPE"], fields["SIZE"], counts, strict=True)
    # Padding fields may share the name "_".
    record = np.dtype(
        [
            (name if name in "xyz" else f"{i}{name}", f"<{PCD_TYPES[kind]}{size}", (int(count),))
            for i, (name, kind, size, count) in enumerate(columns)
        ]
    )
    return _coordinates(Table(record, int(fields["POINTS"][0]), encoding == "ascii", body))


def _read_ply(file: Path) -> Points:
    header, body = _split_header(file.read_bytes(), b"end_header")
    if header[0] != ["ply"]:
        raise ValueError("the first line is not 'ply'")
    encoding = next(words[1] for words in header if words[0] == "format")
    elements = [i for i, words in enumerate(header) if words[0] == "element"]
    first = header[elements[0]]
    if first[1] != "vertex":
        raise ValueError(f"the first element is {first[1]!r}, expected 'vertex'")
    last = elements[1] if len(elements) > 1 else len(header)
    properties = [words[1:] for words in header[elements[0] : last] if words[0] == "property"]
    record = np.dtype([(name, PLY_ORDERS[encoding] + PLY_TYPES[kind], (1,)) for kind, name in properties])
    return _coordinates(Table(record, int(first[2]), encoding == "ascii", body))


def _read_xyz(file: Path) -> Points:
    lines = file.read_text().split("\n")
    if not any(line.split("#")[0].strip() for line in lines):
        return np.empty((0, 3))
    columns: Points = np.loadtxt(lines, ndmin=2)
    if columns.shape[1] < 3:
        raise ValueError(f"{columns.shape[1]} columns")
    return columns[:, :3]


def _read_npy(file: Path) -> Points:
    values = np.load(BytesIO(file.read_bytes()), allow_pickle=False)
    if values.dtype.kind not in "fiu" or values.shape[-1:] != (3,):
        raise ValueError(f"the array holds {values.dtype} in shape {values.shape}")
    points: Points = values.reshape(-1, 3).astype(np.float64)
    return points


READERS: dict[str, Callable[[Path], Points]] = {
    ".pcd": _read_pcd,
    ".ply": _read_ply,
    ".xyz": _read_xyz,
    ".npy": _read_npy,
}


def _split_header(data: bytes, last_key: bytes) -> tuple[list[list[str]], bytes]:
    """Return the words of each header line up to `last_key`'s, and the bytes behind it."""
    lines: list[list[str]] = []
    rest = data
    while rest:
        line, _, rest = rest.partition(b"\n")
        words = line.decode("ascii", errors="replace").split()
        if words and not words[0].startswith("#"):
            lines.append(words)
        if line.startswith(last_key):
            return lines, rest
    raise ValueError(f"the header has no line {last_key.decode()!r}")


def _coordinates(table: Table) -> Points:
    names = table.record.names or ()
    if not {"x", "y", "z"} <= set(names):
        raise ValueError(f"the fields are {names}, expected x, y and z among them")
    if table.count == 0:
        return np.empty((0, 3))
    rows = _text_rows(table) if table.text else _binary_rows(table)
    return np.column_stack([rows[name][:, 0].astype(np.float64) for name in "xyz"])


def _text_rows(table: Table) -> NDArray[np.void]:
    lines = table.body.decode("ascii").splitlines()[: table.count]
    _expect(len(lines), table.count, "lines")
    values = np.loadtxt(lines, ndmin=2)
    width = sum(table.record[name].shape[0] for name in table.record.names or ())
    if values.shape[1] != width:
        raise ValueError(f"{values.shape[1]} columns where the header promises {width}")
    wide = np.dtype([(name, "f8", table.record[name].shape) for name in table.record.names or ()])
    return np.ascontiguousarray(values).view(wide)[:, 0]


def _binary_rows(table: Table) -> NDArray[np.void]:
    _expect(len(table.body), table.count * table.record.itemsize, "bytes")
    return np.frombuffer(table.body, table.record, table.count)


def _expect(found: int, promised: int, what: str) -> None:
    if promised < 0 or found < promised:
        raise ValueError(f"{found} {what} of data where the header promises {promised}")


def _decompress(file: Path, promised: int) -> Points:
    import open3d as o3d

    with o3d.utility.VerbosityContextManager(o3d.utility.VerbosityLevel.Error):
        points: Points = np.array(o3d.io.read_point_cloud(file).points)
    _expect(len(points), promised, "points")
    return points
