"""glTF files: Open3D reads them, and what it should have read is counted here."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from beltsort.perception.formats.content import UnreadableError
from beltsort.sim.mesh_formats.polygons import Polygons


def parse_gltf(data: bytes, path: Path) -> Polygons:
    """Return the triangles of a glTF file (.gltf or .glb).

    Raises
    ------
    UnreadableError
        If it is damaged, or triangles that it promises could not be read.
    """
    import open3d

    try:
        promised = sum(_triangles(_content(data)))
    except (ValueError, TypeError, KeyError, IndexError, RecursionError) as reason:
        raise UnreadableError("its description is damaged, expected glTF 2.0") from reason
    # Open3D's messages go to standard output, which is the command's; what it lost is told by the count.
    with open3d.utility.VerbosityContextManager(open3d.utility.VerbosityLevel.Error):
        read = open3d.io.read_triangle_mesh(path)
    vertices, triangles = np.asarray(read.vertices), np.asarray(read.triangles)
    if len(triangles) < promised:
        raise UnreadableError(
            f"{len(triangles)} triangles could be read of {promised} in the file",
            remedy="export triangles without compression, with all buffers in the file or beside it",
        )
    return Polygons.triangles(vertices, triangles.astype(np.int64))


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
