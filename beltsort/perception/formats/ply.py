"""PLY files: any elements in any order, lists included, as text or binary in either byte order."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate

import numpy as np
from numpy.typing import NDArray

from beltsort.perception.formats.content import Content, UnreadableError, expect, left_over
from beltsort.perception.formats.lines import Header, Line, body_lines, is_number, numbers, split_header

TYPES = {
    **{"char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4"},
    **{"int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4"},
    **{"int64": "i8", "uint64": "u8", "float": "f4", "double": "f8", "float32": "f4", "float64": "f8"},
}
ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}

Values = NDArray[np.generic]


@dataclass(frozen=True)
class Property:
    """A property of an element: `kind` is NumPy's type of a value, `length` that of a list's length."""

    name: str
    kind: str
    length: str | None = None


@dataclass(frozen=True)
class Element:
    """An element that a header declares: `count` records of `properties`."""

    name: str
    count: int
    properties: tuple[Property, ...]

    @property
    def shortest(self) -> int:
        """Bytes of a binary record whose lists are empty."""
        return sum(np.dtype(each.length or each.kind).itemsize for each in self.properties)


@dataclass(frozen=True, eq=False)
class Lists:
    """Lists of one property: `lengths`, shape (n,), and their `values` one behind the other, shape (m,)."""

    lengths: NDArray[np.int64]
    values: Values


Columns = dict[str, Values | Lists]
"""The values of each property of an element, by its name in lower case."""


@dataclass(frozen=True, eq=False)
class PlyFile:
    """What a PLY file holds.

    Attributes
    ----------
    elements
        The properties of each element, by its name.
    counts
        The number of records of each element.
    notes
        What else is in the file and not read.
    """

    elements: dict[str, Columns]
    counts: dict[str, int]
    notes: tuple[str, ...]

    def vertices(self) -> NDArray[np.float64]:
        """Return the coordinates of the vertices, shape (n, 3)."""
        columns = self.elements.get("vertex")
        if columns is None:
            raise UnreadableError(f"the elements are {[*self.elements]}, expected 'vertex' among them")
        given = [columns.get(axis) for axis in "xyz"]
        scalars = [column for column in given if isinstance(column, np.ndarray)]
        if len(scalars) < 3:
            raise UnreadableError(
                f"the properties of a vertex are {[*columns]}, expected x, y and z among them"
            )
        return np.column_stack([column.astype(np.float64) for column in scalars])


def parse_ply(data: bytes) -> Content:
    """Return the vertices of a PLY file, and the number of its faces.

    Raises
    ------
    UnreadableError
        If it is damaged.
    """
    read = read_ply(data)
    return Content(read.vertices(), faces=read.counts.get("face", 0), notes=read.notes)


def read_ply(data: bytes) -> PlyFile:
    """Return all elements of a PLY file.

    Raises
    ------
    UnreadableError
        If it is damaged, or an element is incomplete.
    """
    header = split_header(data, "end_header")
    if header.lines[0] != ["ply"]:
        raise UnreadableError("the first line is not 'ply'")
    encoding = next((" ".join(words[1:2]).lower() for words in header.lines if words[0] == "format"), None)
    if encoding not in ORDERS:
        found = "no line 'format'" if encoding is None else f"format {encoding!r}"
        raise UnreadableError(f"the header has {found}, expected one of {', '.join(ORDERS)}")
    elements = _declared(header.lines, ORDERS[encoding])
    reader = _TextBody(data, header) if encoding == "ascii" else _BinaryBody(data, header)
    columns = {element.name: reader.columns(element) for element in elements}
    return PlyFile(columns, {element.name: element.count for element in elements}, reader.left_over())


def _declared(lines: list[list[str]], order: str) -> list[Element]:
    elements: list[Element] = []
    for words in lines:
        match words:
            case ["element", name, count] if count.isdecimal():
                elements.append(Element(name, int(count), ()))
            case ["property", "list", length, kind, name] if elements and {length, kind} <= TYPES.keys():
                _add(elements, Property(name.lower(), order + TYPES[kind], order + TYPES[length]))
            case ["property", kind, name] if elements and kind in TYPES:
                _add(elements, Property(name.lower(), order + TYPES[kind]))
            case ["element" | "property", *_]:
                line = " ".join(words)[:80]
                raise UnreadableError(
                    f"the header's line {line!r} is not understood, expected 'element NAME COUNT', "
                    "'property TYPE NAME' or 'property list TYPE TYPE NAME'"
                )
    return elements


def _add(elements: list[Element], added: Property) -> None:
    last = elements[-1]
    if added.name in {each.name for each in last.properties}:
        raise UnreadableError(f"element {last.name!r} has the property {added.name!r} twice")
    elements[-1] = Element(last.name, last.count, (*last.properties, added))


class _BinaryBody:
    """Reads one element behind the other from binary data."""

    def __init__(self, data: bytes, header: Header) -> None:
        self.data, self.start = data, header.start

    def columns(self, element: Element) -> Columns:
        expect(
            len(self.data) - self.start,
            element.count * element.shortest,
            f"bytes of element {element.name!r}",
        )
        if element.count == 0 or not element.properties:
            return {each.name: _nothing(each) for each in element.properties}
        lengths = self._first_lengths(element)
        regular = self._regular(element, lengths)
        return self._walked(element) if regular is None else regular

    def left_over(self) -> tuple[str, ...]:
        return left_over(self.data[self.start :], "the last element")

    def _first_lengths(self, element: Element) -> list[int]:
        """Return the lengths of the first record's lists, 0 for other properties."""
        at, lengths = self.start, []
        for each in element.properties:
            length = 0
            if each.length is not None:
                length = self._value(at, each.length)
                at += np.dtype(each.length).itemsize
            at += np.dtype(each.kind).itemsize * (length if each.length else 1)
            lengths.append(length)
        return lengths

    def _value(self, at: int, kind: str) -> int:
        """Return the length of a list, which is at byte `at`."""
        size = np.dtype(kind).itemsize
        if at + size > len(self.data):
            raise UnreadableError("the data end within a list")
        length = int(np.frombuffer(self.data, kind, 1, at)[0])
        if not 0 <= length <= len(self.data):
            raise UnreadableError(f"a list has the length {length}, more than the file holds")
        return length

    def _regular(self, element: Element, lengths: Sequence[int]) -> Columns | None:
        """Return the columns if all records are as long as the first, None if they are not."""
        fields: list[tuple[str, str] | tuple[str, str, tuple[int]]] = []
        for each, length in zip(element.properties, lengths, strict=True):
            if each.length is None:
                fields.append((each.name, each.kind))
            else:
                fields += [(f"{each.name} length", each.length), (each.name, each.kind, (length,))]
        record = np.dtype(fields)
        end = self.start + element.count * record.itemsize
        if end > len(self.data):
            return None
        rows = np.frombuffer(self.data, record, element.count, self.start)
        columns: Columns = {}
        for each, length in zip(element.properties, lengths, strict=True):
            if each.length is None:
                columns[each.name] = rows[each.name]
                continue
            found = rows[f"{each.name} length"]
            if (found != length).any():
                return None
            columns[each.name] = Lists(found.astype(np.int64), rows[each.name].ravel())
        self.start = end
        return columns

    def _walked(self, element: Element) -> Columns:
        """Return the columns of records of different lengths."""
        at = self.start
        found: dict[str, list[NDArray[np.generic]]] = {each.name: [] for each in element.properties}
        sizes = {each.name: np.dtype(each.kind).itemsize for each in element.properties}
        for _ in range(element.count):
            for each in element.properties:
                length = 1
                if each.length is not None:
                    length = self._value(at, each.length)
                    at += np.dtype(each.length).itemsize
                if at + length * sizes[each.name] > len(self.data):
                    raise UnreadableError(f"the data end within element {element.name!r}")
                found[each.name].append(np.frombuffer(self.data, each.kind, length, at))
                at += length * sizes[each.name]
        self.start = at
        return {each.name: _joined(each, found[each.name]) for each in element.properties}


class _TextBody:
    """Reads one element behind the other from lines of text; blank lines are no records."""

    def __init__(self, data: bytes, header: Header) -> None:
        self.lines = body_lines(data, header)
        self.next = 0

    def columns(self, element: Element) -> Columns:
        if not element.properties:
            return {}
        expect(len(self.lines) - self.next, element.count, f"lines of element {element.name!r}")
        lines = self.lines[self.next : self.next + element.count]
        self.next += element.count
        if all(each.length is None for each in element.properties):
            values = numbers(lines, len(element.properties))
            return {each.name: values[:, i] for i, each in enumerate(element.properties)}
        found: dict[str, list[list[float]]] = {each.name: [] for each in element.properties}
        for line in lines:
            for each, values_of in zip(element.properties, _record(element, line), strict=True):
                found[each.name].append(values_of)
        return {
            each.name: _joined(each, [np.array(values) for values in found[each.name]])
            for each in element.properties
        }

    def left_over(self) -> tuple[str, ...]:
        more = len(self.lines) - self.next
        return (f"{more} lines behind the last element are not read",) if more else ()


def _record(element: Element, line: Line) -> list[list[float]]:
    """Return the values of each property of one record."""
    words = line.text.split()
    wrong = [word for word in words if not is_number(word)]
    if wrong:
        raise UnreadableError(f"{wrong[0][:40]!r} is no number", line=line.number)
    values = [float(word) for word in words]
    record, at = [], 0
    for each in element.properties:
        length = 1
        if each.length is not None and at < len(values):
            length, at = _length(values[at], len(values), line), at + 1
        record.append(values[at : at + length])
        at += length
    if at != len(values):
        raise UnreadableError(
            f"{len(values)} numbers where the lists of element {element.name!r} need {at}", line=line.number
        )
    return record


def _length(value: float, most: int, line: Line) -> int:
    if not (0.0 <= value <= most and value == int(value)):
        raise UnreadableError(f"a list of length {value:g} does not fit its line", line=line.number)
    return int(value)


def _nothing(of: Property) -> Values | Lists:
    return _joined(of, [])


def _joined(of: Property, found: Sequence[NDArray[np.generic]]) -> Values | Lists:
    """Return one array of the values of all records, with the lengths of lists."""
    values = np.concatenate(found) if found else np.empty(0)
    if of.length is None:
        return values
    return Lists(np.array([len(each) for each in found], dtype=np.int64), values)


def starts_of(lengths: NDArray[np.int64]) -> list[int]:
    """Return where each list starts among the values of all.

    Examples
    --------
    >>> starts_of(np.array([3, 4, 3]))
    [0, 3, 7]
    """
    return list(accumulate(lengths.tolist(), initial=0))[:-1]
