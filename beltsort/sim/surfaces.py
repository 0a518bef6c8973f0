"""Triangle meshes: surfaces of revolution, and meshes read from files."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from beltsort.errors import CellError
from beltsort.geometry import Points, Pose, transform

Profile = NDArray[np.float64]
"""Outline of a surface of revolution, shape (n, 2): radius and height, metres, from one pole to the other."""

LARGEST_OBJECT = 0.5  # metres; a larger mesh is assumed to be in other units


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


def read_mesh(path: Path | str) -> Mesh:
    """Read a mesh file (PLY, STL, OBJ, OFF, glTF), in metres, its axis along z.

    The mesh is centred in x and y and its lowest point brought to z = 0.

    Raises
    ------
    CellError
        If the file is missing, has no triangles, or is larger than an object in metres.
    """
    import open3d

    if not Path(path).is_file():
        raise CellError(f"no mesh file at {str(path)!r}; give the path of a PLY, STL, OBJ, OFF or glTF file")
    with open3d.utility.VerbosityContextManager(open3d.utility.VerbosityLevel.Error):
        read = open3d.io.read_triangle_mesh(Path(path))
    vertices, triangles = np.asarray(read.vertices), np.asarray(read.triangles)
    if len(triangles) == 0 or not np.isfinite(vertices).all():
        raise CellError(
            f"{str(path)!r} holds {len(triangles)} readable triangles; give a PLY, STL, OBJ, OFF or glTF "
            "mesh with finite vertices"
        )
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    if (high - low).max() > LARGEST_OBJECT:
        raise CellError(
            f"the mesh {str(path)!r} is {(high - low).max():g} m long, expected at most {LARGEST_OBJECT} m; "
            "scale it to metres"
        )
    origin = np.array([(low[0] + high[0]) / 2.0, (low[1] + high[1]) / 2.0, low[2]])
    return Mesh(vertices - origin, triangles.astype(np.int64))
