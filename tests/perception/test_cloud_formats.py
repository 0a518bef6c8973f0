"""What may be written differently from file to file of one format does not change the points."""

import struct
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from beltsort.errors import CloudError
from beltsort.geometry import Points
from beltsort.perception import FileWarning, read_cloud
from tests.laws import cases

COORDINATE = st.floats(-5.0, 5.0, width=32)
CLOUDS = st.lists(st.tuples(COORDINATE, COORDINATE, COORDINATE), min_size=1, max_size=8)
STRUCTS = {"uchar": "B", "char": "b", "ushort": "H", "int": "i", "float": "f", "double": "d"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("formats")


def read(path: Path, content: bytes) -> Points:
    path.write_bytes(content)
    return read_cloud(path)


Property = tuple[str, str | None]
"""Type of a value, and of the length if it is a list's."""

PROPERTIES = st.lists(
    st.tuples(st.sampled_from(sorted(STRUCTS)), st.none() | st.sampled_from(["uchar", "ushort", "int"])),
    max_size=3,
)


class PlyWriter:
    """Writes elements whose other values are drawn."""

    def __init__(self, data: st.DataObject, encoding: str, end_of_line: str) -> None:
        self.data, self.encoding, self.end = data, encoding, end_of_line
        self.header = ["ply", f"format {encoding} 1.0", "comment written for a test"]
        self.body = b""

    def element(
        self, name: str, properties: list[Property], points: list[tuple[float, float, float]]
    ) -> None:
        axes = ["x", "y", "z"] if name == "vertex" else []
        placed: list[tuple[str, Property]] = [(axis, ("float", None)) for axis in axes]
        placed += [(f"{name}{i}", each) for i, each in enumerate(properties)]
        if axes:
            placed = self.data.draw(st.permutations(placed))
        self.header.append(f"element {name} {len(points)}")
        for label, (kind, length) in placed:
            typed = kind if length is None else f"list {length} {kind}"
            self.header.append(f"property {typed} {label}")
        for point in points:
            coordinates = dict(zip(axes, point, strict=False))
            self.record([(label, each, coordinates.get(label)) for label, each in placed])

    def record(self, values: list[tuple[str, Property, float | None]]) -> None:
        words: list[tuple[str, float]] = []
        for _, (kind, length), value in values:
            count = 1 if length is None else self.data.draw(st.integers(0, 3))
            if length is not None:
                words.append((STRUCTS[length], count))
            drawn = [self.data.draw(st.integers(0, 100)) for _ in range(count)]
            words += [(STRUCTS[kind], value if value is not None else each) for each in drawn]
        if self.encoding == "ascii":
            text = " ".join(repr(float(value)) if code in "fd" else str(value) for code, value in words)
            self.body += (text + self.end * self.data.draw(st.integers(1, 2))).encode()
        else:
            order = "<" if "little" in self.encoding else ">"
            self.body += b"".join(struct.pack(order + code, value) for code, value in words)

    def content(self) -> bytes:
        return self.end.join([*self.header, "end_header", ""]).encode() + self.body


@cases(150)
@given(
    data=st.data(),
    points=CLOUDS,
    encoding=st.sampled_from(["ascii", "binary_little_endian", "binary_big_endian"]),
    end_of_line=st.sampled_from(["\n", "\r\n", "\r"]),
    before=st.lists(PROPERTIES.filter(bool), max_size=2),
    vertex=PROPERTIES,
    after=st.booleans(),
)
def test_ply_elements_in_any_order_with_lists(
    folder: Path,
    data: st.DataObject,
    points: list[tuple[float, float, float]],
    encoding: str,
    end_of_line: str,
    before: list[list[Property]],
    vertex: list[Property],
    after: bool,
) -> None:
    writer = PlyWriter(data, encoding, end_of_line)
    for i, properties in enumerate(before):
        writer.element(f"other{i}", properties, [(0.0, 0.0, 0.0)] * data.draw(st.integers(0, 3)))
    writer.element("vertex", vertex, points)
    if after:
        writer.element("camera", [("float", None), ("int", "uchar")], [(0.0, 0.0, 0.0)])
    content = writer.content()
    assert np.array_equal(read(folder / "a.ply", content), np.array(points))
    if writer.body.rstrip():
        with pytest.raises(CloudError, match=r"a\.ply"):
            read(folder / "a.ply", content.rstrip()[: -max(1, len(writer.body) // 3)])


@cases(150)
@given(
    data=st.data(),
    points=CLOUDS,
    encoding=st.sampled_from(["ascii", "binary", "binary_compressed"]),
    columns=st.booleans(),
    left_out=st.sets(st.sampled_from(["SIZE", "TYPE", "COUNT", "VIEWPOINT", "POINTS", "HEIGHT", "VERSION"])),
    lower=st.booleans(),
)
def test_pcd_headers_with_defaults(
    folder: Path,
    data: st.DataObject,
    points: list[tuple[float, float, float]],
    encoding: str,
    columns: bool,
    left_out: set[str],
    lower: bool,
) -> None:
    names = data.draw(st.permutations(["x", "y", "z", "intensity"]))
    values = np.array([[*point, 7.0] for point in points], dtype="<f4")
    table = values[:, [["x", "y", "z", "intensity"].index(name) for name in names]]
    kind = "f" if lower else "F"
    shown = [name.upper() if lower else name for name in names]
    header = {
        "VERSION": ".5" if columns else "0.7",
        "COLUMNS" if columns else "FIELDS": " ".join(shown),
        "SIZE": "4 4 4 4",
        "TYPE": " ".join([kind] * 4),
        "COUNT": "1 1 1 1",
        "WIDTH": str(len(points)),
        "HEIGHT": "1",
        "VIEWPOINT": "0 0 0 1 0 0 0",
        "POINTS": str(len(points)),
    }
    lines = [f"{key} {value}" for key, value in header.items() if key not in left_out]
    body = {
        "ascii": "\n".join(" ".join(repr(float(value)) for value in row) for row in table).encode(),
        "binary": table.tobytes(),
        "binary_compressed": stored(table.T.tobytes()),
    }[encoding]
    content = "\n".join(["# .PCD", *lines, f"DATA {encoding}", ""]).encode() + body
    assert np.array_equal(read(folder / "a.pcd", content), np.array(points))


def stored(data: bytes) -> bytes:
    """Return data as PCD's compression writes what it cannot shorten: literal runs."""
    runs = [data[i : i + 32] for i in range(0, len(data), 32)]
    packed = b"".join(bytes([len(run) - 1]) + run for run in runs)
    return struct.pack("<II", len(packed), len(data)) + packed


@cases(150)
@given(
    data=st.data(),
    points=CLOUDS,
    separator=st.sampled_from([" ", "\t", ",", ", ", ";", "  "]),
    end_of_line=st.sampled_from(["\n", "\r\n", "\r"]),
    suffix=st.sampled_from([".xyz", ".txt", ".csv", ".asc", ".pts", ".TXT"]),
    encoding=st.sampled_from(["utf-8", "utf-8-sig", "utf-16"]),
    title=st.sampled_from(["none", "names", "comment", "slashes", "hash", "count"]),
    further=st.integers(0, 3),
)
def test_text_with_any_separator_and_title(
    folder: Path,
    data: st.DataObject,
    points: list[tuple[float, float, float]],
    separator: str,
    end_of_line: str,
    suffix: str,
    encoding: str,
    title: str,
    further: int,
) -> None:
    names = ["X", "Y", "Z", *["R", "G", "B"][:further]]
    if title in {"names", "slashes", "hash"}:
        names = data.draw(st.permutations(names))
    places = [["X", "Y", "Z", "R", "G", "B"].index(name) for name in names]
    rows = [[(*map(repr, point), "1", "2", "3")[place] for place in places] for point in points]
    titles = {
        "none": [],
        "comment": ["# scanned with care", "// twice"],
        "names": [separator.join(names)],
        "slashes": ["//" + separator.join(names)],
        "hash": ["# " + separator.join(names)],
        "count": [str(len(points))],
    }[title]
    lines = [*titles, "", *(separator.join(row) for row in rows), ""]
    content = end_of_line.join(lines).encode(encoding)
    if title == "count" and len(points) == 1 and further == 0:
        return  # one line with a number, one with three: nothing is wrong with it, and nothing is tested
    assert np.array_equal(read(folder / f"a{suffix}", content), np.array(points))


@cases(100)
@given(points=CLOUDS, line=st.integers(0, 7), torn=st.sampled_from(["1.5", "1 2 3 4", "1 2 three", "1 2 3;"]))
def test_a_torn_line_is_named(
    folder: Path, points: list[tuple[float, float, float]], line: int, torn: str
) -> None:
    rows = [" ".join(map(repr, point)) for point in points]
    at = 1 + line % len(rows)
    with pytest.raises(CloudError, match=rf"a\.xyz, line {at + 2}: "):
        read(folder / "a.xyz", "\n".join(["# x y z", *rows[:at], torn, *rows[at:]]).encode())


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("a.csv", "time,x,y,z\n7,1,2,3\n8,4,5,6\n", None),
        ("a.csv", '"z [m]";"x [m]";"y [m]"\n3;1;2\n6;4;5\n', None),
        ("a.csv", '"x","y","z"\n"1","2","3"\n"4","5","6"\n', None),
        ("a.csv", '"Points:1","Points:0","Points:2"\n2,1,3\n5,4,6\n', None),
        ("a.csv", "x,y,z\n1 2 3\n4 5 6\n", None),
        ("a.xyz", "# gr\xf6\xdfe\n1 2 3\n4 5 6\n", None),
        ("a.txt", "0,1 0,2 0,3\n", r"line 1: '0,1 0,2 0,3' has both.*decimal points"),
        ("a.pts", "2\n1 2 3 -100 1 1 1\n4 5 6 -100 1 1 1\n", None),
        ("a.xyz", "1 2 3 # the first\n\n4 5 6 // the second", None),
        ("a.csv", "time,east,north,up\n7,1,2,3\n", r"line 1: 'time,east,north,up'.*x, y and z"),
        ("a.csv", "x,y,z\n1,2,3,4\n", r"line 1: 3 columns\b.*\b4 numbers\b.*line 2"),
        ("a.csv", "1,2,\n", r"line 1: .*','"),
        ("a.csv", "1,2,3\n4,,6\n", r"line 2: '' is no number"),
        ("a.csv", "0,1;0,2;0,3\n", r"line 1: '0,1' is no number.*decimal points"),
        ("a.pts", "3\n1 2 3\n4 5 6\n", r"line 1: 2 points\b.*\b3\b"),
        ("a.txt", "scanned on Tuesday\n", r"line 1: 'scanned on Tuesday'.*x, y and z"),
        ("a.txt", "# nothing\n", "0 points"),
        ("a.xyz", "\x00\xff\xfe", "no text|neither"),
        ("a.xyz", "nan nan nan\n", r"\b1 points\b.*finite"),
        ("a.xyz", "1_0 2 3\n4 5 6\n", r"line 1: '1_0 2 3'"),
    ],
)
def test_text(tmp_path: Path, name: str, content: str, said: str | None) -> None:
    if said is None:
        assert np.array_equal(read(tmp_path / name, content.encode("latin-1")), [[1, 2, 3], [4, 5, 6]])
    else:
        with pytest.raises(CloudError, match=said):
            read(tmp_path / name, content.encode("latin-1"))


def head(width: int | str, height: int, points: int, data: str) -> str:
    return f"FIELDS x y z\nWIDTH {width}\nHEIGHT {height}\nPOINTS {points}\nDATA {data}\n"


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (
            head(2, 2, 2, "ascii") + "1 2 3\n4 5 6\n",
            r"\b2 points\b.*2 x 2 = 4",
        ),
        (head(2, 1, 2, "ascii") + "1 2 3\n4 5 six\n", r"line 7: 'six'"),
        (head("two", 1, 2, "ascii") + "1 2 3\n", r"WIDTH\b.*'two'"),
        (
            head(1, 1, 1, "ascii").replace("x y z", "x y y") + "1 2 3\n",
            "each once",
        ),
        ("FIELDS x y z\nSIZE 4 4\nDATA ascii\n1 2 3\n", r"SIZE\b.*\b2 entries\b.*\b3 fields\b"),
        ("FIELDS x y z\nTYPE F F Q\nWIDTH 1\nDATA ascii\n1 2 3\n", r"'z'.*'Q'"),
        ("FIELDS x y z\nDATA ascii\n1 2 3\n", r"'POINTS'.*'WIDTH'"),
        ("VERSION 0.7\nDATA ascii\n", r"'FIELDS'"),
    ],
)
def test_pcd_headers_that_make_no_sense(tmp_path: Path, content: str, said: str) -> None:
    with pytest.raises(CloudError, match=said):
        read(tmp_path / "a.pcd", content.encode())


PLY = (
    b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
    b"end_header\n"
)
GRID = np.arange(12.0).reshape(4, 3)
ROWS = [tuple(row) for row in GRID]


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("a.pcd", head(1, 1, 1, "ascii").encode() + b"1 2 3\n4 5 6\n", "1 lines"),
        ("a.pcd", head(1, 1, 1, "binary").encode() + bytes(12) + b"more", "4 bytes"),
        ("a.ply", PLY + b"1 2 3\n4 5 6\n7 8 9\n", "2 lines"),
        ("a.pts", b"1\n1 2 3\n4 5 6\n", "1 lines"),
        ("a.pcd", b"FIELDS x y z\nWIDTH 1\nVIEWPOINT 1 2 3\nDATA ascii\n1 2 3\n", "VIEWPOINT"),
    ],
)  # fmt: skip
def test_data_left_over_are_told(tmp_path: Path, name: str, content: bytes, said: str) -> None:
    with pytest.warns(FileWarning, match=rf"{name}: .*{said}"):
        assert len(read(tmp_path / name, content)) == 1


@pytest.mark.parametrize(
    "array",
    [
        GRID,
        np.pad(GRID, ((0, 0), (0, 1))),
        np.pad(GRID.reshape(2, 2, 3), ((0, 0), (0, 0), (0, 1))),
        np.asfortranarray(np.arange(12, dtype=">i2").reshape(4, 3)),
        np.array(ROWS, [("f0", "<f4"), ("f1", "<f4"), ("f2", "<f4")]),
        np.array([(9, *row) for row in ROWS], [("i", "u1"), ("x", "f8"), ("y", "f8"), ("z", "f8")]),
    ],
)  # fmt: skip
def test_arrays(tmp_path: Path, array: np.ndarray[tuple[int, ...], np.dtype[np.generic]]) -> None:
    np.save(tmp_path / "a.npy", array)
    assert np.array_equal(read_cloud(tmp_path / "a.npy"), np.arange(12.0).reshape(4, 3))


@pytest.mark.parametrize(
    ("array", "said"),
    [
        (np.zeros((3, 50)), r"\(3, 50\).*points\.T"),
        (np.zeros((3, 48, 64)), r"\(3, 48, 64\).*moveaxis"),
        (np.zeros((50, 6)), r"\(50, 6\).*\[:, :3\]"),
        (np.zeros((48, 64), np.uint16), r"\(48, 64\).*cloud_from_depth"),
        (np.zeros(50), r"\(50,\)"),
        (np.zeros((50, 3), complex), "complex128"),
        (np.array([{"x": 1}]), "object"),
        (np.zeros(4, [("u", "f4"), ("v", "f4")]), r"'u', 'v'.*x, y, z"),
        (np.zeros(4, [("x", "f4"), ("y", "f4"), ("z", "S3")]), r"numbers x, y, z"),
    ],
)
def test_arrays_without_points(
    tmp_path: Path, array: np.ndarray[tuple[int, ...], np.dtype[np.generic]], said: str
) -> None:
    np.save(tmp_path / "a.npy", array, allow_pickle=True)
    with pytest.raises(CloudError, match=said):
        read_cloud(tmp_path / "a.npy")
