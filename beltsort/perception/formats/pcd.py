"""PCD files of PCL, versions .5 to .7: text, binary, or compressed by LZF."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from beltsort import _core
from beltsort.geometry import Points
from beltsort.perception.formats.content import Content, UnreadableError, expect, left_over
from beltsort.perception.formats.lines import Header, body_lines, numbers, split_header

TYPES = {"F": "f", "I": "i", "U": "u"}
ENCODINGS = "ascii, binary or binary_compressed"

Columns = dict[str, NDArray[np.generic]]


@dataclass(frozen=True)
class Table:
    """What a header declares.

    Attributes
    ----------
    record
        Type of one point: field x, y, z and others, each with a shape.
    count
        Number of points.
    grid
        WIDTH and HEIGHT, if the header has them.
    encoding
        Of the data: the word behind DATA.
    """

    record: np.dtype[np.void]
    count: int
    grid: tuple[int, int] | None
    encoding: str


def parse_pcd(data: bytes) -> Content:
    """Return the content of a PCD file.

    Raises
    ------
    UnreadableError
        If it is damaged, or the header contradicts itself.
    """
    header = split_header(data, "DATA")
    fields = {words[0].upper(): words[1:] for words in header.lines}
    table = _declared(fields)
    columns, notes = _columns(table, data, header)
    _check_grid(table)
    points: Points = np.empty((table.count, 3))
    for axis, name in enumerate("xyz"):
        points[:, axis] = columns[name]
    camera, more = _camera(fields.get("VIEWPOINT"))
    return Content(points, camera, notes=(*notes, *more))


def viewpoint_of(data: bytes) -> Points | None:
    """Return the camera's position by a PCD file's header, shape (3,), None if it names none."""
    try:
        lines = split_header(data, "DATA").lines
    except UnreadableError:
        return None
    return _camera(next((words[1:] for words in lines if words[0].upper() == "VIEWPOINT"), None))[0]


def _declared(fields: dict[str, list[str]]) -> Table:
    """Return what the header declares; SIZE, TYPE, COUNT and POINTS have PCL's defaults."""
    names = fields.get("FIELDS") or fields.get("COLUMNS")  # of version .5
    if not names:
        raise UnreadableError("the header has no line 'FIELDS', expected x, y and z among the fields")
    settings = {
        "SIZE": fields.get("SIZE") or ["4"] * len(names),
        "TYPE": fields.get("TYPE") or ["F"] * len(names),
        "COUNT": fields.get("COUNT") or ["1"] * len(names),
    }
    for key, given in settings.items():
        if len(given) != len(names):
            raise UnreadableError(f"{key} has {len(given)} entries for {len(names)} fields")
    columns = enumerate(zip(names, *settings.values(), strict=True))
    # Padding fields may share the name "_"; names of other fields get their index.
    record = [
        (
            name.lower() if name.lower() in {"x", "y", "z"} else f"{i}{name}",
            _type(name, kind, size),
            (_whole("COUNT", count, least=1),),
        )
        for i, (name, size, kind, count) in columns
    ]
    found = [name for name, *_ in record]
    if any(found.count(axis) != 1 for axis in "xyz"):
        raise UnreadableError(f"the fields are {found}, expected x, y and z among them, each once")
    width, height = (_whole(key, fields[key][0]) if fields.get(key) else None for key in ("WIDTH", "HEIGHT"))
    grid = None if width is None else (width, 1 if height is None else height)
    if fields.get("POINTS"):
        count = _whole("POINTS", fields["POINTS"][0])
    elif grid is not None:
        count = grid[0] * grid[1]
    else:
        raise UnreadableError(
            "the header has neither a line 'POINTS' nor 'WIDTH', expected the number of points"
        )
    if count < 0:
        raise UnreadableError(f"the header promises {count} points")
    return Table(np.dtype(record), count, grid, (fields["DATA"] or [""])[0].lower())


def _whole(key: str, word: str, least: int | None = None) -> int:
    try:
        number = int(word)
    except ValueError:
        raise UnreadableError(f"{key} is {word[:40]!r}, expected a whole number") from None
    if least is not None and number < least:
        raise UnreadableError(f"{key} is {number}, expected at least {least}")
    return number


def _type(name: str, kind: str, size: str) -> str:
    known = {"F": "248", "I": "1248", "U": "1248"}
    if size not in [*known.get(kind.upper(), "")]:
        raise UnreadableError(
            f"field {name!r} has TYPE {kind[:20]!r} and SIZE {size[:20]!r}, "
            "expected F, I or U and 1, 2, 4 or 8"
        )
    return f"<{TYPES[kind.upper()]}{size}"


def _columns(table: Table, data: bytes, header: Header) -> tuple[Columns, tuple[str, ...]]:
    """Return the values of each field, and notes about what follows them."""
    match table.encoding:
        case "ascii":
            return _text_columns(table, data, header)
        case "binary":
            return _binary_columns(table, memoryview(data)[header.start :])
        case "binary_compressed":
            return _compressed_columns(table, memoryview(data)[header.start :])
    raise UnreadableError(f"DATA is {table.encoding!r}, expected {ENCODINGS}")


def _text_columns(table: Table, data: bytes, header: Header) -> tuple[Columns, tuple[str, ...]]:
    names = table.record.names or ()
    widths = [table.record[name].shape[0] for name in names]
    firsts = dict(zip(names, np.cumsum([0, *widths[:-1]]).tolist(), strict=True))
    lines = body_lines(data, header)
    expect(len(lines), table.count, "lines of data")
    values = numbers(lines[: table.count], sum(widths))
    more = len(lines) - table.count
    notes = (f"{more} lines behind the {table.count} points are not read",) if more else ()
    return {name: values[:, first] for name, first in firsts.items()}, notes


def _binary_columns(table: Table, body: memoryview) -> tuple[Columns, tuple[str, ...]]:
    size = table.count * table.record.itemsize
    expect(len(body), size, "bytes of data")
    rows = np.frombuffer(body[:size], table.record, table.count)
    notes = left_over(bytes(body[size:]), f"the {table.count} points")
    return {name: rows[name][:, 0] for name in "xyz"}, notes


def _compressed_columns(table: Table, body: memoryview) -> tuple[Columns, tuple[str, ...]]:
    """Undo PCD's compression, which keeps all values of the first field before those of the next."""
    packed, unpacked = (int.from_bytes(body[i : i + 4], "little") for i in (0, 4))
    expect(len(body) - 8, packed, "bytes of data")
    size = table.count * table.record.itemsize
    if unpacked != size:
        raise UnreadableError(f"{unpacked} bytes of data where the header promises {size}")
    stored = bytes(body[8 : 8 + packed])
    data = _core.lzf_decompress(stored, size)
    if data is None and packed == unpacked:
        data = stored  # writers store what compression does not shorten
    if data is None:
        raise UnreadableError("the compressed data is damaged")
    columns, start = {}, 0
    for name in table.record.names or ():
        field = table.record[name]
        columns[name] = np.frombuffer(data, field.base, table.count * field.shape[0], start)[
            :: field.shape[0]
        ]
        start += table.count * field.itemsize
    return columns, left_over(bytes(body[8 + packed :]), "the compressed data")


def _check_grid(table: Table) -> None:
    """Refuse a header whose WIDTH and HEIGHT give another number of points than POINTS.

    The data are checked first: a number that they cannot hold is more likely the wrong one.
    """
    if table.grid is not None and table.grid[0] * table.grid[1] != table.count:
        width, height = table.grid
        raise UnreadableError(
            f"POINTS promises {table.count} points, WIDTH x HEIGHT {width} x {height} = {width * height}",
            remedy="correct the one that is wrong",
        )


def _camera(viewpoint: list[str] | None) -> tuple[Points | None, tuple[str, ...]]:
    """Return the camera's position by the header's VIEWPOINT, and a note if it cannot be used.

    VIEWPOINT has translation and quaternion (w first). The identity, which writers put there for want of
    anything better, names no position.
    """
    if viewpoint is None:
        return None, ()
    try:
        values = np.array([float(word) for word in viewpoint])
    except ValueError:
        values = np.empty(0)
    if values.shape != (7,) or not np.isfinite(values).all():
        return None, (
            f"VIEWPOINT is {' '.join(viewpoint)[:80]!r}, expected 7 finite numbers: it is not used",
        )
    identity = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
    return (None, ()) if np.array_equal(values, identity) else (values[:3], ())
