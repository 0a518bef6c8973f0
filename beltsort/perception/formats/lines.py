"""Headers of text lines, and tables of numbers as text."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, overload

import numpy as np
from numpy.typing import NDArray

from beltsort.perception.formats.content import UnreadableError

BYTE_ORDER_MARK = b"\xef\xbb\xbf"
NO_NUMBER = re.compile(r"[-+]?(?:nan\(\w*\)|\d\.#[A-Z]+\d*)", re.IGNORECASE)
"""How C libraries write what is no number: -nan(ind), 1.#IND, 1.#QNAN, -1.#INF00."""


class Line(NamedTuple):
    """A line that is not blank, stripped, and its number in the file, from 1."""

    number: int
    text: str


@dataclass(frozen=True)
class Lines(Sequence[Line]):
    """Lines that are not blank: their `texts` and `places`, the numbers of the lines in the file.

    A million `Line` objects take longer to make than their numbers to be parsed.
    """

    texts: list[str]
    places: Sequence[int]

    def __len__(self) -> int:
        """Return how many lines there are."""
        return len(self.texts)

    @overload
    def __getitem__(self, index: int) -> Line: ...

    @overload
    def __getitem__(self, index: slice) -> "Lines": ...

    def __getitem__(self, index: int | slice) -> "Line | Lines":
        """Return one line, or some."""
        if isinstance(index, slice):
            return Lines(self.texts[index], self.places[index])
        return Line(self.places[index], self.texts[index])


@dataclass(frozen=True)
class Header:
    """The words of each line of a header, and where the data behind it starts.

    Attributes
    ----------
    lines
        Words of each line that is neither blank nor a comment.
    start
        Index of the first byte behind the header.
    length
        Number of lines in the header.
    """

    lines: list[list[str]]
    start: int
    length: int


def split_header(data: bytes, last_key: str) -> Header:
    """Return the header up to the line that starts with `last_key`.

    Lines end in LF, CR LF, or in CR alone if the first line does.
    """
    lines: list[list[str]] = []
    start, number = (len(BYTE_ORDER_MARK) if data.startswith(BYTE_ORDER_MARK) else 0), 0
    end_of_line = _end_of_line(data)
    while start < len(data):
        end = data.find(end_of_line, start)
        end = len(data) if end < 0 else end
        words = data[start:end].decode("utf-8", errors="replace").split()
        start, number = end + 1, number + 1
        if words and not words[0].startswith("#"):
            lines.append(words)
        if words and words[0].lower() == last_key.lower():
            return Header(lines, start, number)
    raise UnreadableError(f"the header has no line {last_key!r}")


def _end_of_line(data: bytes) -> bytes:
    at = data.find(b"\r")
    alone = at >= 0 and data[at + 1 : at + 2] != b"\n" and b"\n" not in data[:at]
    return b"\r" if alone else b"\n"


def split_lines(text: str) -> list[str]:
    """Return the lines of a text, which end in LF, CR LF or CR."""
    return text.replace("\r\n", "\n").replace("\r", "\n").split("\n")


def lines_of(text: str, first: int = 1) -> Lines:
    """Return the lines of a text that are not blank, stripped; `first` is the number of its first line."""
    stripped = list(map(str.strip, split_lines(text)))
    places = [number for number, line in enumerate(stripped, start=first) if line]
    return Lines([line for line in stripped if line], places)


def with_plain_nan(text: str) -> str:
    """Return the text with `nan` for what C libraries write instead."""
    return NO_NUMBER.sub("nan", text) if "#" in text or "(" in text else text


def body_lines(data: bytes, header: Header) -> Lines:
    """Return the lines behind a header."""
    try:
        text = data[header.start :].decode("utf-8")
    except UnicodeDecodeError as reason:
        line = header.length + 1 + data.count(b"\n", header.start, header.start + reason.start)
        raise UnreadableError(
            "it holds bytes that are no text, expected numbers as text", line=line
        ) from reason
    return lines_of(with_plain_nan(text), header.length + 1)


def numbers(lines: Lines, columns: int, separator: str | None = None) -> NDArray[np.float64]:
    """Return lines of numbers as an array, shape (len(lines), columns).

    Parameters
    ----------
    lines
        The lines.
    columns
        Numbers in each line.
    separator
        Between them; None: blanks and tabs.
    """
    if not lines:
        return np.empty((0, columns))
    try:
        values = np.loadtxt(lines.texts, ndmin=2, delimiter=separator, comments=None)
    except ValueError:
        values = np.empty((0, 0))
    if values.shape != (len(lines), columns):
        raise _first_fault(lines, columns, separator)
    return values


def _first_fault(lines: Sequence[Line], columns: int, separator: str | None) -> UnreadableError:
    """Return what is wrong with the first line that is not so many numbers."""
    for line in lines:
        words = [word.strip() for word in line.text.split(separator)]
        wrong = [word for word in words if not is_number(word)]
        if wrong:
            problem = f"{wrong[0][:40]!r} is no number, expected {columns} numbers"
            return UnreadableError(
                problem, line=line.number, remedy="correct the line, or write the file again"
            )
        if len(words) != columns:
            problem = f"{len(words)} columns, expected {columns}"
            return UnreadableError(
                problem, line=line.number, remedy="complete the line, or write the file again"
            )
    return UnreadableError(f"the data are not {columns} numbers in each line")


def is_number(word: str) -> bool:
    """Return whether a word is a number as text, nan and inf included.

    Examples
    --------
    >>> is_number("-1e-3"), is_number("nan"), is_number("0,5"), is_number("1_000")
    (True, True, False, False)
    """
    try:
        float(word)
    except ValueError:
        return False
    return "_" not in word
