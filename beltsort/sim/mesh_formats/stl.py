"""STL files, binary or text; several solids of a text file are one mesh."""

import re

import numpy as np

from beltsort.perception.formats.content import UnreadableError, left_over
from beltsort.perception.formats.lines import is_number
from beltsort.sim.mesh_formats.polygons import Polygons

HEADER = 84  # bytes: 80 of text, and the number of triangles
RECORD = np.dtype([("normal", "<f4", (3,)), ("corners", "<f4", (3, 3)), ("attributes", "<u2")])
VERTEX = re.compile(rb"^[ \t]*vertex[ \t]+(\S+)[ \t]+(\S+)[ \t]+(\S+)[ \t]*$", re.MULTILINE | re.IGNORECASE)
SOLID, END_OF_SOLID, FACET, END_OF_FACET = (
    re.compile(rb"^[ \t]*" + word + rb"\b", re.MULTILINE | re.IGNORECASE)
    for word in (rb"solid", rb"end[ \t]*solid", rb"facet", rb"end[ \t]*facet")
)
LINE_END = re.compile(rb"\r\n|\r")


def parse_stl(data: bytes) -> Polygons:
    """Return the triangles of an STL file.

    Raises
    ------
    UnreadableError
        If it is truncated, or a facet has not three corners.
    """
    promised = int.from_bytes(data[80:HEADER], "little")
    size = HEADER + promised * RECORD.itemsize
    is_text = data.lstrip()[:5].lower() == b"solid" and b"facet" in data.lower()
    if len(data) >= HEADER and (size == len(data) or not is_text):
        if size > len(data):
            held = (len(data) - HEADER) // RECORD.itemsize
            raise UnreadableError(f"{held} triangles of data where the header promises {promised}")
        records = np.frombuffer(data, RECORD, promised, HEADER)
        notes = left_over(data[size:], f"the {promised} triangles")
        return _soup(records["corners"].reshape(-1, 3).astype(np.float64), notes)
    if not is_text:
        raise UnreadableError("it is neither binary STL nor begins with 'solid'")
    return _text(LINE_END.sub(b"\n", data))


def _text(data: bytes) -> Polygons:
    words = VERTEX.findall(data)
    facets, facet_ends = len(FACET.findall(data)), len(END_OF_FACET.findall(data))
    solids, solid_ends = len(SOLID.findall(data)), len(END_OF_SOLID.findall(data))
    if (facets, solids) != (facet_ends, solid_ends):
        raise UnreadableError(f"{facet_ends} of {facets} facets and {solid_ends} of {solids} solids end")
    if len(words) != 3 * facets:
        raise UnreadableError(f"{facets} facets have {len(words)} corners, expected three each")
    for word in (each for triple in words for each in triple):
        if not is_number(word.decode("ascii", errors="replace")):
            raise UnreadableError(
                f"{word[:40]!r} is no number", line=1 + data[: data.find(word)].count(b"\n")
            )
    return _soup(np.array(words, dtype=np.float64).reshape(-1, 3), ())


def _soup(corners: np.ndarray[tuple[int, ...], np.dtype[np.float64]], notes: tuple[str, ...]) -> Polygons:
    """Return triangles of corners, shape (3 m, 3), with each vertex once."""
    vertices, index = np.unique(corners, axis=0, return_inverse=True)
    return Polygons.triangles(vertices, index.reshape(-1, 3).astype(np.int64), notes)
