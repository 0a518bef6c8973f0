"""Prisms over polygons, and writers of them in every format of meshes."""

import struct

import numpy as np
from hypothesis import strategies as st

from beltsort.geometry import Points


@st.composite
def star_polygons(draw: st.DrawFn) -> Points:
    """A polygon around the origin, not convex in general, counter-clockwise, shape (n, 2), metres."""
    n = draw(st.integers(3, 9))
    radii = draw(st.lists(st.floats(0.01, 0.1), min_size=n, max_size=n))
    angles = 2.0 * np.pi * np.arange(n) / n
    outline: Points = np.column_stack([np.cos(angles), np.sin(angles)]) * np.array(radii)[:, None]
    return outline


def prism(outline: Points, height: float = 0.05) -> tuple[Points, list[list[int]]]:
    """Return vertices and faces of a prism: two faces of n corners, and n of four."""
    n = len(outline)
    bottom, top = (np.column_stack([outline, np.full(n, z)]) for z in (0.0, height))
    sides = [[i, (i + 1) % n, n + (i + 1) % n, n + i] for i in range(n)]
    return np.vstack([bottom, top]), [[*range(n)][::-1], [*range(n, 2 * n)], *sides]


def shoelace(outline: Points) -> float:
    x, y = outline.T
    return float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum() / 2.0)


def as_obj(vertices: Points, faces: list[list[int]], style: str) -> bytes:
    separator = "\t" if style == "tabs" else " "
    lines = [separator.join(["v", *map(repr, vertex)]) for vertex in vertices.tolist()]
    for face in faces:
        names = [str(i + 1) for i in face]
        if style == "relative":
            names = [str(i - len(vertices)) for i in face]
        if style == "texture":
            names = [f"{name}/1/1" for name in names]
        if style == "normals":
            names = [f"{name}//1" for name in names]
        lines.append(separator.join(["f", *names]))
        if style == "broken":
            lines[-1] = lines[-1].replace(" ", " \\\n ", 2)
    if style == "faces first":
        lines = lines[len(vertices) :] + lines[: len(vertices)]
    return "\n".join(["# a prism", "o prism", *lines, ""]).encode()


def as_off(vertices: Points, faces: list[list[int]], style: str) -> bytes:
    counts = f"{len(vertices)} {len(faces)} 0"
    titles = {
        "one line": [f"OFF {counts}"],
        "one word": [f"OFF{counts}"],
        "comments": ["# by hand", "OFF", "# counts", counts],
    }
    head = titles.get(style, ["OFF", counts])
    colour = " 255 0 0" if style == "colours" else ""
    rows = [" ".join(map(repr, vertex)) for vertex in vertices.tolist()]
    rows += [f"{len(face)} {' '.join(map(str, face))}{colour}" for face in faces]
    return "\n".join([*head, *rows]).encode()


def as_ply(vertices: Points, faces: list[list[int]], style: str) -> bytes:
    name = "vertex_index" if style == "ascii" else "vertex_indices"
    header = [
        "ply", f"format {style} 1.0", f"element vertex {len(vertices)}",
        *(f"property double {axis}" for axis in "xyz"),
        f"element face {len(faces)}", "property uchar flags", f"property list uchar int {name}",
        "end_header", "",
    ]  # fmt: skip
    head = "\n".join(header).encode()
    if style == "ascii":
        rows = [" ".join(map(repr, vertex)) for vertex in vertices.tolist()]
        rows += [f"7 {len(face)} {' '.join(map(str, face))}" for face in faces]
        return head + "\n".join(rows).encode()
    order = "<" if "little" in style else ">"
    packed = [struct.pack(f"{order}BB{len(face)}i", 7, len(face), *face) for face in faces]
    return head + vertices.astype(f"{order}f8").tobytes() + b"".join(packed)


WRITERS = {
    **{
        f"{style}.obj": as_obj
        for style in ("plain", "tabs", "relative", "texture", "normals", "broken", "faces first")
    },
    **{f"{style}.off": as_off for style in ("plain", "one line", "one word", "comments", "colours")},
    **{f"{style}.ply": as_ply for style in ("ascii", "binary_little_endian", "binary_big_endian")},
}
