"""glTF files: Open3D reads them, and what it should have read is counted here."""

import json
import re
from collections.abc import Iterator
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np

from beltsort.perception.formats.content import UnreadableError
from beltsort.sim.mesh_formats.polygons import Polygons
from beltsort.util.extras import extra

MARKUP = re.compile(r"\x1b\[[\d;]*m|\[Open3D WARNING\]")
"""Colours of a terminal, and the mark of a message."""


def parse_gltf(data: bytes, path: Path) -> Polygons:
    """Return the triangles of a glTF file (.gltf or .glb).

    Raises
    ------
    UnreadableError
        If it is damaged, or triangles that it promises could not be read.
    """
    with extra("perception"):
        import open3d

    try:
        content = _content(data)
        promised = sum(_triangles(content))
        _check_readable(content, path.parent)
    except (ValueError, TypeError, KeyError, IndexError, AttributeError, RecursionError) as reason:
        raise UnreadableError("its description is damaged, expected glTF 2.0") from reason
    # Open3D prints its messages, and a command's standard output is not the place for them.
    with redirect_stdout(StringIO()) as printed:
        read = open3d.io.read_triangle_mesh(path)
    said = " ".join(MARKUP.sub("", printed.getvalue()).split())
    vertices, triangles = np.asarray(read.vertices), np.asarray(read.triangles)
    if len(triangles) < promised:
        raise UnreadableError(
            f"{len(triangles)} triangles could be read of {promised} in the file"
            + (f" (Open3D says: {said})" if said else ""),
            remedy="export triangles without compression, with all buffers in the file or beside it",
        )
    notes = (f"Open3D says: {said}",) if said else ()
    return Polygons.triangles(vertices, triangles.astype(np.int64), notes)


def _check_readable(content: dict[str, Any], folder: Path) -> None:
    """Refuse files whose triangles are compressed, or in a buffer that is not there."""
    compressed = [name for name in content.get("extensionsRequired", []) if "compression" in name]
    if compressed:
        raise UnreadableError(f"it requires {', '.join(compressed)}", remedy="export it without compression")
    uris = [buffer.get("uri", "data:") for buffer in content.get("buffers", [])]
    missing = [uri for uri in uris if not (uri.startswith("data:") or (folder / unquote(uri)).is_file())]
    if missing:
        raise UnreadableError(f"its buffer {missing[0]!r} is missing", remedy="put it beside the file")


def _content(data: bytes) -> dict[str, Any]:
    """Return the JSON part."""
    if data[:4] == b"glTF":
        data = data[20 : 20 + int.from_bytes(data[12:16], "little")]
    content: dict[str, Any] = json.loads(data)
    return content


def _triangles(content: dict[str, Any]) -> Iterator[int]:
    """Yield the number of triangles of each primitive of each node in the scene."""
    nodes = content.get("nodes", [])
    scenes = content.get("scenes", [])
    left = list(scenes[content.get("scene", 0)].get("nodes", [])) if scenes else list(range(len(nodes)))
    for _ in range(len(nodes)):  # a node has one parent at most
        if not left:
            return
        node = nodes[left.pop()]
        left += node.get("children", [])
        for primitive in content["meshes"][node["mesh"]]["primitives"] if "mesh" in node else []:
            accessor = primitive.get("indices", primitive["attributes"]["POSITION"])
            corners = content["accessors"][accessor]["count"]
            match primitive.get("mode", 4):
                case 4:  # triangles
                    yield corners // 3
                case 5 | 6:  # strips and fans
                    yield corners - 2
