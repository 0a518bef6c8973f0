"""Triangle meshes: surfaces of revolution, and meshes read from files."""

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from os import PathLike
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from beltsort.errors import CellError
from beltsort.geometry import Points, Pose, transform
from beltsort.perception import FileWarning
from beltsort.perception.formats.content import UnreadableError
from beltsort.sim.mesh_formats.gltf import parse_gltf
from beltsort.sim.mesh_formats.obj import parse_obj
from beltsort.sim.mesh_formats.off import parse_off
from beltsort.sim.mesh_formats.ply import parse_mesh_ply
from beltsort.sim.mesh_formats.polygons import Polygons, triangulate
from beltsort.sim.mesh_formats.stl import parse_stl

Profile = NDArray[np.float64]
"""Outline of a surface of revolution, shape (n, 2): radius and height, metres, from one pole to the other."""

PARSERS: dict[str, Callable[[bytes], Polygons]] = {
    ".ply": parse_mesh_ply,
    ".stl": parse_stl,
    ".obj": parse_obj,
    ".off": parse_off,
}
GLTF = (".gltf", ".glb")
FORMATS = "PLY, STL, OBJ, OFF or glTF"

LARGEST_OBJECT = 0.5  # metres; a larger mesh is assumed to be in other units
KEPT = 32  # meshes read; a simulation reads those of its classes again for every belt


@dataclass(frozen=True)
class Mesh:
    """A triangle mesh: `vertices`, shape (n, 3), metres, and `triangles`, shape (m, 3), vertex indices."""

    vertices: Points
    triangles: NDArray[np.int64]

    def moved(self, pose: Pose) -> "Mesh":
        """Return the mesh under a rigid transform, shape (4, 4)."""
        return Mesh(transform(pose, self.vertices), self.triangles)

    def scaled(self, radial: float, axial: float) -> "Mesh":
        """Return the mesh stretched by `radial` in x and y and by `axial` in z."""
        return Mesh(self.vertices * [radial, radial, axial], self.triangles)


def refine(profile: Profile, step: float) -> Profile:
    """Return the same outline with points at most `step` metres apart."""
    lengths = np.linalg.norm(np.diff(profile, axis=0), axis=1)
    pieces = np.maximum(np.ceil(lengths / step).astype(int), 1)
    inner = [
        np.linspace(a, b, n, endpoint=False)
        for a, b, n in zip(profile[:-1], profile[1:], pieces, strict=True)
    ]
    return np.vstack([*inner, profile[-1]])


def revolve(profile: Profile, segments: int = 64) -> Mesh:
    """Return the closed surface of revolution of `profile` about the z axis.

    Parameters
    ----------
    profile
        Outline from the lower pole to the upper one, where the radius is 0; other radii are positive.
    segments
        Number of meridians.

    Returns
    -------
    Mesh
        Watertight; normals point outwards if the outline runs counter-clockwise in the (radius, height)
        plane.
    """
    if np.any(profile[[0, -1], 0] != 0.0) or np.any(profile[1:-1, 0] <= 0.0):
        raise CellError(
            f"the outline has the radii {profile[:, 0].tolist()}, expected 0 at both ends and positive ones "
            "between; correct them"
        )
    angles = np.linspace(0.0, 2.0 * np.pi, segments, endpoint=False)
    rings = np.stack(
        np.broadcast_arrays(
            profile[1:-1, :1] * np.cos(angles), profile[1:-1, :1] * np.sin(angles), profile[1:-1, 1:]
        ),
        axis=-1,
    )  # (n - 2, segments, 3)
    poles = np.array([[0.0, 0.0, profile[0, 1]], [0.0, 0.0, profile[-1, 1]]])
    return Mesh(np.vstack([rings.reshape(-1, 3), poles]), _ring_triangles(len(profile) - 2, segments))


def _ring_triangles(rings: int, segments: int) -> NDArray[np.int64]:
    """Join neighbouring rings by quads cut in two, and the outer rings to the two poles, shape (m, 3)."""
    ring = np.arange(segments)
    following = (ring + 1) % segments
    quads = []
    for k in range(rings - 1):
        a, b = k * segments + ring, k * segments + following
        quads += [np.column_stack([a, b, b + segments]), np.column_stack([a, b + segments, a + segments])]
    bottom, top, last = rings * segments, rings * segments + 1, (rings - 1) * segments
    caps = [
        np.column_stack([following, ring, np.full(segments, bottom)]),
        np.column_stack([last + ring, last + following, np.full(segments, top)]),
    ]
    return np.vstack([*quads, *caps])


def read_mesh(path: str | PathLike[str]) -> Mesh:
    """Read a mesh file (PLY, STL, OBJ, OFF, glTF), in metres, its axis along z.

    Faces of more than three corners are cut into triangles, and vertices that no face uses are left out. The
    mesh is centred in x and y and its lowest point brought to z = 0. All bodies of a file are one object.

    Raises
    ------
    CellError
        If the file is missing, damaged or incomplete, has no triangles or a vertex that is not finite, or is
        larger than an object in metres.

    Warns
    -----
    FileWarning
        If bodies of the mesh stand apart from each other, a face crosses itself, or the file has more than is
        read.
    """
    file = Path(path)
    if not file.is_file():
        raise CellError(f"no mesh file at {str(path)!r}; give the path of a {FORMATS} file")
    stamp = file.stat()
    mesh, notes = _read(file, stamp.st_mtime_ns, stamp.st_size)
    for note in notes:
        warnings.warn(f"{file}: {note}", FileWarning, stacklevel=2)
    return Mesh(mesh.vertices.copy(), mesh.triangles.copy())  # the caller's own


@lru_cache(maxsize=KEPT)
def _read(file: Path, _changed: int, _size: int) -> tuple[Mesh, tuple[str, ...]]:
    """Return the mesh in a file, and notes for warnings; the other arguments tell its versions apart."""
    suffix = file.suffix.lower()
    if suffix not in (*PARSERS, *GLTF):
        raise CellError(f"the mesh {file} has suffix {file.suffix!r}, expected {FORMATS}: convert the file")
    remedy = f"give a complete {FORMATS} file"
    try:
        data = file.read_bytes()
        mesh, notes = _standing(parse_gltf(data, file) if suffix in GLTF else PARSERS[suffix](data))
    except OSError as reason:
        raise CellError(f"cannot read {file}: {reason.strerror}; {remedy}") from reason
    except UnreadableError as reason:
        raise CellError(reason.message(file, f"0 triangles are used: {remedy}")) from reason
    except Exception as reason:  # whatever else a parser stumbles over means that the file is damaged
        raise CellError(f"cannot read {file}: its content is damaged; {remedy}") from reason
    extent = float(np.ptp(mesh.vertices, axis=0).max())
    if extent > LARGEST_OBJECT:
        raise CellError(
            f"the mesh {str(file)!r} is {extent:g} m long, expected at most {LARGEST_OBJECT} m; "
            "scale it to metres"
        )
    return mesh, notes


def _standing(polygons: Polygons) -> tuple[Mesh, tuple[str, ...]]:
    """Return the mesh of polygons, centred above the origin, and notes for warnings."""
    lost = np.flatnonzero(~np.isfinite(polygons.vertices).all(axis=1))
    if lost.size:
        raise UnreadableError(f"{lost.size} vertices are not finite, the first is vertex {lost[0] + 1}")
    triangles, crossed = triangulate(polygons)
    if not len(triangles):
        raise UnreadableError(f"it has {len(polygons.vertices)} vertices and no face")
    used, index = np.unique(triangles, return_inverse=True)
    vertices = polygons.vertices[used]
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    vertices -= [(low[0] + high[0]) / 2.0, (low[1] + high[1]) / 2.0, low[2]]
    mesh = Mesh(vertices, index.reshape(-1, 3).astype(np.int64))
    notes = list(polygons.notes)
    if crossed:
        notes.append(f"the outlines of {crossed} faces cross themselves: triangles may lie outside of them")
    if (bodies := _bodies(mesh)) > 1:
        notes.append(f"it has {bodies} bodies that stand apart, one object here: export one object per file")
    return mesh, tuple(notes)


def _bodies(mesh: Mesh) -> int:
    """Return the number of bodies that planes across an axis separate, for the axis where it is largest."""
    corners = mesh.vertices[mesh.triangles]
    most = 1
    for low, high in zip(corners.min(axis=1).T, corners.max(axis=1).T, strict=True):
        order = np.argsort(low)
        reached = np.maximum.accumulate(high[order])
        most = max(most, 1 + int((low[order][1:] > reached[:-1]).sum()))
    return most
