"""Wavefront OBJ files: vertices and polygons; materials, normals and texture coordinates are left out."""

from collections.abc import Iterator

import numpy as np

from beltsort.perception.formats.content import UnreadableError
from beltsort.perception.formats.lines import is_number, split_lines
from beltsort.sim.mesh_formats.polygons import Indices, Polygons

FREE_FORM = {"curv", "curv2", "surf"}


def parse_obj(data: bytes) -> Polygons:
    """Return the faces of an OBJ file.

    Raises
    ------
    UnreadableError
        If a vertex or a face is not understood, or a face has a corner that is no vertex.
    """
    vertices: list[list[float]] = []
    lengths: list[int] = []
    corners: list[int] = []
    lines: list[int] = []
    curved = 0
    for number, words in _records(data.decode("utf-8", errors="replace")):
        match words[0]:
            case "v":
                vertices.append(_vertex(words[1:], number))
            case "f":
                face = [_index(word, len(vertices), number) for word in words[1:]]
                if len(face) < 3:
                    raise UnreadableError(f"a face of {len(face)} corners, expected at least 3", line=number)
                lengths.append(len(face))
                corners += face
                lines.append(number)
            case key:
                curved += key in FREE_FORM
    faces, indices = np.array(lengths, dtype=np.int64), np.array(corners, dtype=np.int64)
    _check(indices, faces, lines, len(vertices))
    notes = (f"{curved} curves and surfaces of free form are not read",) if curved else ()
    return Polygons(np.array(vertices).reshape(-1, 3), faces, indices, notes)


def _records(text: str) -> Iterator[tuple[int, list[str]]]:
    """Yield the words of each line and its number; a line that ends in a backslash continues."""
    before: list[str] = []
    for number, line in enumerate(split_lines(text), start=1):
        content = line.partition("#")[0].rstrip() if "#" in line else line.rstrip()
        if content.endswith("\\"):
            before += content[:-1].split()
            continue
        words = before + content.split()
        before = []
        if words:
            yield number, words
    if before:
        yield number, before


def _vertex(words: list[str], line: int) -> list[float]:
    if len(words) < 3 or not all(map(is_number, words[:3])):
        raise UnreadableError(f"the vertex {' '.join(words)[:40]!r}, expected three numbers", line=line)
    return [float(word) for word in words[:3]]


def _index(word: str, vertices: int, line: int) -> int:
    """Return the vertex index of a corner, from 0; a negative one counts back from the last vertex."""
    try:
        index = int(word.partition("/")[0])
    except ValueError:
        index = 0
    if index == 0 or index < -vertices:
        raise UnreadableError(f"the corner {word[:40]!r} of a face, expected a vertex", line=line)
    return index - 1 if index > 0 else vertices + index


def _check(corners: Indices, lengths: Indices, lines: list[int], vertices: int) -> None:
    """Refuse corners beyond the last vertex; a face may stand in front of its vertices."""
    beyond = np.flatnonzero(corners >= vertices)
    if beyond.size:
        face = int(np.searchsorted(np.cumsum(lengths), beyond[0], side="right"))
        raise UnreadableError(
            f"a face has vertex {corners[beyond[0]] + 1}, the file has {vertices} vertices", line=lines[face]
        )
