"""Point records behind a header: PCD and PLY files.

Open3D is not used for it: it fills up truncated text and PLY files with zeros or uninitialised memory, only
prints a warning, and allocates whatever size a header declares. Here declared sizes are compared with the
bytes that are there before memory is allocated.
"""

from dataclasses import dataclass
from io import StringIO

import numpy as np
from numpy.typing import NDArray

from beltsort import _core
from beltsort.geometry import Points

PCD_TYPES = {"F": "f", "I": "i", "U": "u"}
PLY_TYPES = {
    **{"char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4"},
    **{"int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4"},
    **{"float": "f4", "double": "f8", "float32": "f4", "float64": "f8"},
}
PLY_ORDERS = {"ascii": "<", "binary_little_endian": "<", "binary_big_endian": ">"}

Columns = dict[str, NDArray[np.generic]]


@dataclass(frozen=True)
class Table:
    """What a header declares: `count` records of type `record` at the start of `body`."""

    record: np.dtype[np.void]
    count: int
    body: memoryview

    def __post_init__(self) -> None:
        """Refuse records without coordinates."""
        names = self.record.names or ()
        if not {"x", "y", "z"} <= set(names):
            raise ValueError(f"the fields are {names}, expected x, y and z among them")
        if self.count < 0:
            raise ValueError(f"the header promises {self.count} points")


def parse_pcd(data: bytes) -> Points:
    """Return the points of a PCD file, shape (n, 3); whatever is raised means that it is damaged."""
    header, body = _split_header(data, b"DATA")
    fields = {words[0]: words[1:] for words in header}
    counts = fields.get("COUNT", ["1"] * len(fields["FIELDS"]))
    columns = zip(fields["FIELDS"], fields["TYPE"], fields["SIZE"], counts, strict=True)
    # Padding fields may share the name "_".
    record = np.dtype(
        [
            (name if name in "xyz" else f"{i}{name}", f"<{PCD_TYPES[kind]}{size}", (int(count),))
            for i, (name, kind, size, count) in enumerate(columns)
        ]
    )
    return _coordinates(Table(record, int(fields["POINTS"][0]), body), fields["DATA"][0])


def parse_ply(data: bytes) -> Points:
    """Return the vertices of a PLY file, shape (n, 3); whatever is raised means that it is damaged."""
    header, body = _split_header(data, b"end_header")
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
    return _coordinates(Table(record, int(first[2]), body), encoding)


def expect(found: int, promised: int, what: str) -> None:
    """Raise a `ValueError` if a file holds less than its header declares."""
    if found < promised:
        raise ValueError(f"{found} {what} of data where the header promises {promised}")


def _split_header(data: bytes, last_key: bytes) -> tuple[list[list[str]], memoryview]:
    """Return the words of each header line up to `last_key`'s, and the bytes behind it."""
    lines: list[list[str]] = []
    start = 0
    while start < len(data):
        end = data.find(b"\n", start)
        end = len(data) if end < 0 else end
        line, start = data[start:end], end + 1
        words = line.decode("ascii", errors="replace").split()
        if words and not words[0].startswith("#"):
            lines.append(words)
        if line.startswith(last_key):
            return lines, memoryview(data)[start:]
    raise ValueError(f"the header has no line {last_key.decode()!r}")


def _coordinates(table: Table, encoding: str) -> Points:
    if table.count == 0:
        return np.empty((0, 3))
    match encoding:
        case "ascii":
            columns = _text_columns(table)
        case "binary" | "binary_little_endian" | "binary_big_endian":
            columns = _binary_columns(table)
        case "binary_compressed":
            columns = _compressed_columns(table)
        case _:
            raise ValueError(f"DATA is {encoding!r}, expected ascii, binary or binary_compressed")
    points: Points = np.empty((table.count, 3))
    for axis, name in enumerate("xyz"):
        points[:, axis] = columns[name]
    return points


def _text_columns(table: Table) -> Columns:
    names = table.record.names or ()
    widths = [table.record[name].shape[0] for name in names]
    firsts = dict(zip(names, np.cumsum([0, *widths[:-1]]).tolist(), strict=True))
    body = bytes(table.body).strip()
    expect(body.count(b"\n") + 1 if body else 0, table.count, "lines")
    values = np.loadtxt(StringIO(body.decode("ascii")), ndmin=2, max_rows=table.count)
    expect(len(values), table.count, "lines")
    if values.shape[1] != sum(widths):
        raise ValueError(f"{values.shape[1]} columns where the header promises {sum(widths)}")
    return {name: values[:, first] for name, first in firsts.items()}


def _binary_columns(table: Table) -> Columns:
    expect(len(table.body), table.count * table.record.itemsize, "bytes")
    rows = np.frombuffer(table.body, table.record, table.count)
    return {name: rows[name][:, 0] for name in "xyz"}


def _compressed_columns(table: Table) -> Columns:
    """Undo PCD's compression, which keeps all values of the first field before those of the next."""
    packed, unpacked = (int.from_bytes(table.body[i : i + 4], "little") for i in (0, 4))
    expect(len(table.body) - 8, packed, "bytes")
    size = table.count * table.record.itemsize
    if unpacked != size:
        raise ValueError(f"{unpacked} bytes of data where the header promises {size}")
    data = _core.lzf_decompress(bytes(table.body[8 : 8 + packed]), size)
    if data is None:
        raise ValueError("the compressed data is damaged")
    columns, start = {}, 0
    for name in table.record.names or ():
        field = table.record[name]
        columns[name] = np.frombuffer(data, field.base, table.count * field.shape[0], start)[
            :: field.shape[0]
        ]
        start += table.count * field.itemsize
    return columns
