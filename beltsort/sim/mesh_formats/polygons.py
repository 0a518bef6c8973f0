"""Polygons of a mesh file, and their triangulation."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from beltsort.geometry import Points
from beltsort.perception.formats.content import UnreadableError

FLAT = 1e-12
"""Twice the area of a triangle without area, in proportion to the polygon's extent squared."""

Indices = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Polygons:
    """The faces of a mesh, as a file has them.

    Attributes
    ----------
    vertices
        Shape (n, 3), in the file's unit.
    lengths
        Number of corners of each face, at least 3, shape (m,).
    corners
        Vertex indices of all corners, one face behind the other, shape (sum of `lengths`,).
    notes
        What else is in the file and not read, for a warning.
    """

    vertices: Points
    lengths: Indices
    corners: Indices
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Refuse faces of fewer than three corners, and corners that are no vertices."""
        if self.lengths.size and self.lengths.min() < 3:
            face = int(self.lengths.argmin())
            raise UnreadableError(f"face {face + 1} has {self.lengths[face]} corners, expected at least 3")
        outside = np.flatnonzero((self.corners < 0) | (self.corners >= len(self.vertices)))
        if outside.size:
            face = int(np.searchsorted(np.cumsum(self.lengths), outside[0], side="right"))
            raise UnreadableError(
                f"face {face + 1} has the vertex index {self.corners[outside[0]]}, expected 0 to "
                f"{len(self.vertices) - 1}"
            )

    @classmethod
    def triangles(cls, vertices: Points, corners: Indices, notes: tuple[str, ...] = ()) -> "Polygons":
        """Return faces of three corners each, `corners` of shape (m, 3)."""
        return cls(vertices, np.full(len(corners), 3), corners.ravel(), notes)


def triangulate(polygons: Polygons) -> tuple[Indices, int]:
    """Return the triangles of all faces, and the number of faces whose outline crosses itself.

    A face of n corners gives n - 2 triangles: a quad is cut along the diagonal inside it, other faces by
    clipping ears. A face that crosses itself is cut from its first corner, inside or not.

    Returns
    -------
    triangles
        Vertex indices, shape (sum of n - 2, 3).
    crossed
        Number of faces that cross themselves.
    """
    starts = np.cumsum(polygons.lengths) - polygons.lengths
    three, four = (polygons.corners[starts[polygons.lengths == n][:, None] + np.arange(n)] for n in (3, 4))
    halves, crossed = _halves(polygons.vertices, four)
    found = [three, halves]
    for face in np.flatnonzero(polygons.lengths > 4).tolist():
        corners = polygons.corners[starts[face] : starts[face] + polygons.lengths[face]]
        cut, crosses = _cut(_flattened(polygons.vertices[corners]))
        crossed += crosses
        found.append(corners[cut])
    return np.vstack(found), crossed


def _halves(vertices: Points, quads: Indices) -> tuple[Indices, int]:
    """Cut quads, shape (m, 4), along the diagonal that lies inside; also return how many cross themselves."""
    one, other = (
        _agree(vertices, quads[:, [0, 1, 2, 0, 2, 3]]),
        _agree(vertices, quads[:, [0, 1, 3, 1, 2, 3]]),
    )
    order = np.where((one | ~other)[:, None], [[0, 1, 2, 0, 2, 3]], [[0, 1, 3, 1, 2, 3]])
    triangles = np.take_along_axis(quads, order, axis=1).reshape(-1, 3)
    return triangles, int((~one & ~other).sum())


def _agree(vertices: Points, halves: Indices) -> NDArray[np.bool_]:
    """Return whether the two triangles of each quad, shape (m, 6), do not face opposite sides."""
    a, b, c = np.moveaxis(vertices[halves].reshape(-1, 2, 3, 3), 2, 0)
    normals = np.cross(b - a, c - a)
    agree: NDArray[np.bool_] = (normals[:, 0] * normals[:, 1]).sum(axis=-1) >= 0.0
    return agree


def _flattened(outline: Points) -> Points:
    """Return the outline of a polygon in its plane, counter-clockwise, shape (n, 2)."""
    following = np.roll(outline, -1, axis=0)
    normal = np.cross(outline - outline[0], following - outline[0]).sum(axis=0)
    drop = int(np.abs(normal).argmax())
    flat = outline[:, [(drop + 1) % 3, (drop + 2) % 3]]
    return flat if normal[drop] >= 0.0 else flat * [1.0, -1.0]


def _cut(outline: Points) -> tuple[Indices, bool]:
    """Return triangles of a polygon, shape (n, 2), as its corners' indices, and whether it crosses itself."""
    fan = _fan(len(outline))
    before, after = np.roll(outline, 1, axis=0), np.roll(outline, -1, axis=0)
    convex = (_turn(before, outline, after) >= 0.0).all() and (_turn(*outline[fan.T]) >= 0.0).all()
    if convex:
        return fan, False
    clipped = None if _crosses(outline, after) else _clipped(outline)
    return (fan, True) if clipped is None else (clipped, False)


def _crosses(starts: Points, ends: Points) -> bool:
    """Return whether two of the edges, shape (n, 2) each, cross within both."""
    a, b, c, d = starts[:, None], ends[:, None], starts[None], ends[None]
    return bool(((_turn(a, b, c) * _turn(a, b, d) < 0.0) & (_turn(c, d, a) * _turn(c, d, b) < 0.0)).any())


def _clipped(outline: Points) -> Indices | None:
    """Clip the ears of a polygon, shape (n, 2), one by one; None if there is none."""
    left = list(range(len(outline)))
    least = FLAT * float(np.ptp(outline, axis=0).max()) ** 2
    triangles = []
    while len(left) > 3:
        corners = outline[left]
        turns = _turn(np.roll(corners, 1, axis=0), corners, np.roll(corners, -1, axis=0))
        ear = next((i for i in np.flatnonzero(turns > least).tolist() if _is_empty(corners, i)), None)
        if ear is None:  # what has no area may be clipped wherever it is
            flat = np.flatnonzero(np.abs(turns) <= least)
            if not flat.size:
                return None
            ear = int(flat[0])
        triangles.append((left[ear - 1], left[ear], left[(ear + 1) % len(left)]))
        del left[ear]
    return np.array([*triangles, left])


def _is_empty(corners: Points, ear: int) -> bool:
    """Return whether no other corner lies in the triangle of a corner and its neighbours."""
    a, b, c = corners[ear - 1], corners[ear], corners[(ear + 1) % len(corners)]
    within = (_turn(a, b, corners) >= 0.0) & (_turn(b, c, corners) >= 0.0) & (_turn(c, a, corners) >= 0.0)
    # Corners in the same place are neighbours, or join the outline of a hole to that around it.
    same = np.array([(corners == corner).all(axis=1) for corner in (a, b, c)]).any(axis=0)
    return not (within & ~same).any()


def _turn(a: Points, b: Points, c: Points) -> NDArray[np.float64]:
    """Return twice the area of triangles a, b, c, shape (..., 2) each, positive if counter-clockwise."""
    u, v = b - a, c - a
    turn: NDArray[np.float64] = u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]
    return turn


def _fan(corners: int) -> Indices:
    """Cut a polygon from its first corner, shape (corners - 2, 3)."""
    n = np.arange(1, corners - 1)
    return np.column_stack([np.zeros_like(n), n, n + 1])
