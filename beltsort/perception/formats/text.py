"""Clouds as text, one point a line: .xyz, .txt, .csv, .asc and .pts files."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from beltsort.perception.formats.content import Content, UnreadableError
from beltsort.perception.formats.lines import Line, Lines, is_number, lines_of, numbers, with_plain_nan

COMMENTS = ("#", "//")
ENCODINGS = {b"\xef\xbb\xbf": "utf-8-sig", b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16"}
"""Encodings by the byte order mark at the start of a file."""
PARAVIEW = {"points:0": "x", "points:1": "y", "points:2": "z"}
SEPARATORS = (
    "separate numbers by blanks, tabs, commas or semicolons, with decimal points, and nothing after the last"
)


class Layout(NamedTuple):
    """How the lines are laid out.

    Attributes
    ----------
    separator
        Between numbers; None: blanks and tabs.
    columns
        Numbers in each line.
    axes
        Columns of x, y and z.
    """

    separator: str | None
    columns: int
    axes: tuple[int, int, int]


def parse_text(data: bytes) -> Content:
    """Return the points of a text file.

    A line that starts with # or // is a comment, and so is the rest of a line behind them. The columns are x,
    y, z and others, unless a line in front of the first point names them in another order. A whole number
    alone in the first line (.pts) is the number of points.

    Raises
    ------
    UnreadableError
        If a line is not understood.
    """
    titles, rows = _titles_and_rows(with_plain_nan(_decoded(data)))
    if not rows:
        if any(not title.text.startswith(COMMENTS) for title in titles):
            raise _no_title(titles[0])
        return Content(np.empty((0, 3)))
    promised, first = None, rows[0]
    if first.text.isdecimal() and len(rows) > 1 and not rows[1].text.isdecimal():
        promised, rows = int(first.text), rows[1:]
    layout = _layout(titles, rows[0])
    more = 0
    if promised is not None:
        more = len(rows) - promised
        if more < 0:
            raise UnreadableError(f"{len(rows)} points follow, expected {promised}", line=first.number)
        rows = rows[:promised]
    points = numbers(rows, layout.columns, layout.separator)[:, layout.axes]
    notes = (f"{more} lines behind the {promised} points are not read",) if more else ()
    return Content(points, notes=notes)


def _decoded(data: bytes) -> str:
    """Return the text without quotes, which some writers put around every value; comments may be garbled."""
    encoding = next((name for mark, name in ENCODINGS.items() if data.startswith(mark)), "utf-8")
    return data.decode(encoding, errors="replace").replace('"', "")


def _titles_and_rows(text: str) -> tuple[Sequence[Line], Lines]:
    """Return the lines in front of the first point, and the points without comments."""
    lines = lines_of(text)
    if not any(mark in text for mark in COMMENTS):
        first = next((i for i, line in enumerate(lines) if _begins_with_number(line.text)), len(lines))
        return lines[:first], lines[first:]
    titles: list[Line] = []
    rows, places = list[str](), list[int]()
    for line in lines:
        content = line.text
        for mark in COMMENTS:
            if mark in content:
                content = content.split(mark, 1)[0].rstrip()
        if not content:
            if not rows:
                titles.append(line)
        elif rows or _begins_with_number(content):
            rows.append(content)
            places.append(line.number)
        else:
            titles.append(line)
    return titles, Lines(rows, places)


def _begins_with_number(content: str) -> bool:
    first = content.split(_separator(content))[0].split()
    return bool(first) and is_number(
        first[0].replace(",", ".")
    )  # a decimal comma is no title, but refused later


def _separator(content: str) -> str | None:
    return next((mark for mark in ";," if mark in content), None)


def _layout(titles: Sequence[Line], row: Line) -> Layout:
    """Return the layout of the points, of which `row` is the first."""
    separator = _separator(row.text)
    words = [word.strip() for word in row.text.split(separator)]
    if not words[-1]:
        problem = f"it ends in {separator!r}, expected a number behind it"
        raise UnreadableError(problem, line=row.number, remedy=SEPARATORS)
    wrong = next((word for word in words if not is_number(word)), None)
    if wrong is not None:
        problem = f"{wrong[:40]!r} is no number"
        if " " in wrong:
            problem = f"{row.text[:40]!r} has both commas or semicolons and blanks between numbers"
        raise UnreadableError(problem, line=row.number, remedy=SEPARATORS)
    if len(words) < 3:
        raise UnreadableError(
            f"{len(words)} columns, expected x, y and z", line=row.number, remedy=SEPARATORS
        )
    for title in reversed(titles):
        names = _names(title)
        if not set("xyz") <= set(names):
            continue
        if len(names) == len(words):
            return Layout(separator, len(words), (names.index("x"), names.index("y"), names.index("z")))
        if not title.text.startswith(COMMENTS):
            raise UnreadableError(
                f"{len(names)} columns are named, {len(words)} numbers follow in line {row.number}",
                line=title.number,
            )
    if any(not title.text.startswith(COMMENTS) for title in titles):
        raise _no_title(next(title for title in titles if not title.text.startswith(COMMENTS)))
    return Layout(separator, len(words), (0, 1, 2))


def _names(title: Line) -> list[str]:
    """Return the names of columns in a title, in lower case, without units in brackets.

    Examples
    --------
    >>> _names(Line(1, "//X Y Z"))
    ['x', 'y', 'z']
    >>> _names(Line(1, "x [m];y [m];Points:2"))
    ['x', 'y', 'z']
    """
    words = title.text.lstrip("#/ \t").split(_separator(title.text))
    names = [word.partition("[")[0].partition("(")[0].strip().lower() for word in words]
    return [PARAVIEW.get(name, name) for name in names]


def _no_title(title: Line) -> UnreadableError:
    return UnreadableError(
        f"{title.text[:40]!r} is neither numbers nor names of columns, expected x, y and z among them",
        line=title.number,
        remedy="name the columns x, y and z, or start the line with #",
    )
