"""The neighbour graph on the half-sphere: to the nearest point north, south, east and west.

North is the direction towards the point straight above the belt end, east that of growing azimuth; a bearing
is the angle between north and the great circle to another point, as on a globe. At the top itself, where
north is undefined, north and east are their limits on the way up along azimuth 0.

The four quadrants cover all directions and distance is not limited, so an edge may span a gap of unreachable
points; it does not mean that the way is free. For the same reason no sample's graph has been seen to
fall into parts, but that is not proven: users of a graph check it (`components`).
"""

from collections import deque
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from beltsort.geometry import Points, direction_of

Edges = NDArray[np.int64]
"""Undirected edges, shape (m, 2): indices of points, the smaller one first, rows ascending."""

BEARINGS = {"north": 0.0, "east": 90.0, "south": 180.0, "west": -90.0}
"""Degrees, clockwise as seen from outside."""

ROUNDING = 1e-12  # a point at exactly 45 degrees belongs to both bearings


def bearings(start: Points, points: Points) -> NDArray[np.float64]:
    """Return the bearings of `points`, shape (n, 3), seen from `start`, shape (3,): degrees, shape (n,)."""
    north, east = _north_and_east(start)
    return np.degrees(np.arctan2(points @ east, points @ north))


def neighbour_edges(points: Points, reachable: NDArray[np.bool_]) -> Edges:
    """Connect each reachable point with the nearest other one within 45 degrees of each bearing.

    Nearest along the sphere, the first one of equals. An edge stands if either end asks for it.

    Parameters
    ----------
    points
        On a sphere about the origin, shape (n, 3).
    reachable
        Which of them are reachable, shape (n,).

    Examples
    --------
    >>> points = np.array([[0.8, 0.0, 0.6], [0.6, 0.0, 0.8], [0.0, 0.0, 1.0]])
    >>> neighbour_edges(points, np.array([True, True, True])).tolist()
    [[0, 1], [1, 2]]
    """
    nodes = np.flatnonzero(reachable)
    found = set()
    for i in nodes:
        others = nodes[nodes != i]
        nearness = points[others] @ points[i]
        for inside in _quadrants(points[i], points[others]):
            if inside.any():
                j = others[inside][np.argmax(nearness[inside])]
                found.add((min(i, j), max(i, j)))
    return np.array(sorted(found), dtype=np.int64).reshape(-1, 2)


def steps_from(start: int, edges: Edges, count: int) -> NDArray[np.float64]:
    """Return the number of edges on the shortest path from `start` to each of `count` points, or infinity."""
    ways: list[list[int]] = [[] for _ in range(count)]
    for i, j in edges.tolist():
        ways[i].append(j)
        ways[j].append(i)
    steps = np.full(count, np.inf)
    steps[start] = 0.0
    waiting = deque([start])
    while waiting:
        at = waiting.popleft()
        for further in ways[at]:
            if np.isinf(steps[further]):
                steps[further] = steps[at] + 1.0
                waiting.append(further)
    return steps


def components(nodes: Sequence[int], edges: Edges, count: int) -> list[list[int]]:
    """Return the connected parts of the graph on `nodes`, ascending, the largest first."""
    left, parts = sorted(nodes), []
    while left:
        near = np.isfinite(steps_from(left[0], edges, count))
        parts.append([node for node in left if near[node]])
        left = [node for node in left if not near[node]]
    return sorted(parts, key=len, reverse=True)


def _quadrants(start: Points, points: Points) -> list[NDArray[np.bool_]]:
    """Return which points lie within 45 degrees of each bearing, in the order of `BEARINGS`."""
    north, east = (points @ way for way in _north_and_east(start))
    ways = [(north, east), (east, north), (-north, east), (-east, north)]
    return [along + ROUNDING >= np.abs(aside) for along, aside in ways]


def _north_and_east(start: Points) -> tuple[Points, Points]:
    """Return the unit tangents at a point of the sphere, shape (3,) each."""
    a, e = np.radians(direction_of(start))
    north = np.array([-np.sin(e) * np.cos(a), -np.sin(e) * np.sin(a), np.cos(e)])
    return north, np.array([-np.sin(a), np.cos(a), 0.0])
