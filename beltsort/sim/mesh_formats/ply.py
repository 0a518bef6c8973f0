"""PLY files of meshes."""

import numpy as np

from beltsort.perception.formats.content import UnreadableError
from beltsort.perception.formats.ply import Lists, read_ply
from beltsort.sim.mesh_formats.polygons import Polygons

CORNERS = ("vertex_indices", "vertex_index")


def parse_mesh_ply(data: bytes) -> Polygons:
    """Return the faces of a PLY file.

    Raises
    ------
    UnreadableError
        If it is damaged or incomplete, or has triangle strips.
    """
    read = read_ply(data)
    if read.counts.get("tristrips"):
        raise UnreadableError("it has triangle strips, expected faces", remedy="export faces")
    columns = read.elements.get("face", {})
    lists = {name: column for name, column in columns.items() if isinstance(column, Lists)}
    corners = next((lists[name] for name in CORNERS if name in lists), None)
    if corners is None and len(lists) == 1:
        corners = next(iter(lists.values()))
    if corners is None:
        if read.counts.get("face"):
            raise UnreadableError(f"a face has the properties {[*columns]}, expected 'vertex_indices'")
        corners = Lists(np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64))
    return Polygons(read.vertices(), corners.lengths, corners.values.astype(np.int64), read.notes)
