"""OFF files as text, with normals or colours or without."""

import re

import numpy as np

from beltsort.perception.formats.content import UnreadableError
from beltsort.perception.formats.lines import Line, is_number, lines_of
from beltsort.sim.mesh_formats.polygons import Polygons

KEY = re.compile(r"(ST)?C?N?OFF", re.IGNORECASE)
"""The first word; the counts may follow it without a blank, as in ModelNet's files."""


def parse_off(data: bytes) -> Polygons:
    """Return the faces of an OFF file.

    Raises
    ------
    UnreadableError
        If it is truncated, or a line is not understood.
    """
    lines = [
        Line(line.number, text)
        for line in lines_of(data.decode("utf-8", errors="replace"))
        if (text := line.text.partition("#")[0].strip())
    ]
    key = KEY.match(lines[0].text) if lines else None
    if key is None or "BINARY" in lines[0].text.upper():
        raise UnreadableError("the first word is not 'OFF' (as text)")
    counts = lines[0].text[key.end() :].split()
    body = lines[1:]
    if not counts:  # they may also stand on the line of the key
        counts, body = (body[0].text.split(), body[1:]) if body else ([], [])
    if len(counts) < 2 or not all(word.isdecimal() for word in counts[:2]):
        raise UnreadableError(f"the counts are {counts}, expected the numbers of vertices and faces")
    vertices, faces = (int(word) for word in counts[:2])
    if len(body) < vertices + faces:
        raise UnreadableError(
            f"{len(body)} lines follow where {vertices} vertices and {faces} faces are promised"
        )
    more = len(body) - vertices - faces
    found = [_face(line) for line in body[vertices : vertices + faces]]
    return Polygons(
        np.array([_vertex(line) for line in body[:vertices]]).reshape(-1, 3),
        np.array([len(face) for face in found], dtype=np.int64),
        np.array([index for face in found for index in face], dtype=np.int64),
        (f"{more} lines behind the last face are not read",) if more else (),
    )


def _vertex(line: Line) -> list[float]:
    words = line.text.split()[:3]
    if len(words) < 3 or not all(map(is_number, words)):
        raise UnreadableError(f"the vertex {line.text[:40]!r}, expected three numbers", line=line.number)
    return [float(word) for word in words]


def _face(line: Line) -> list[int]:
    """Return the corners of a face; colours may follow them."""
    count, *words = line.text.split()
    corners = words[: int(count)] if count.isdecimal() else []
    if not corners or len(corners) < int(count) or not all(word.isdecimal() for word in corners):
        raise UnreadableError(
            f"the face {line.text[:40]!r}, expected its number of corners and as many vertices",
            line=line.number,
        )
    return [int(word) for word in corners]
