"""What the camera sees of cups, and whether an object reaches the edge of the image."""

import numpy as np
from numpy.typing import NDArray

from beltsort.geometry import Points, Pose

EDGE = 2  # pixels
CELLS = 4  # grid cells per radius of a disc


def crossings(points: Points, height: NDArray[np.float64], world_from_camera: Pose, level: float) -> Points:
    """Return where lines of sight that end below `level` cross that height, shape (m, 2), world x and y.

    Parameters
    ----------
    points
        Shape (n, 3), camera frame, metres.
    height
        Their height in the world, shape (n,), metres; NaN where there is none.
    world_from_camera
        The camera's pose, shape (4, 4).
    level
        Metres above the belt. A camera below it gives m = 0.
    """
    eye = world_from_camera[:3, 3]
    if eye[2] <= level:
        return np.empty((0, 2))
    below = np.flatnonzero(height < level)
    share = (eye[2] - level) / (eye[2] - height[below])
    sideways: Points = np.einsum("ij,kj->ik", points[below], world_from_camera[:2, :3])
    sideways *= share[:, None]
    return sideways + eye[:2]


def share_seen(passed: Points, centre: Points, radius: float) -> float:
    """Return the share of a disc that lines of sight cross, counted on a grid of `CELLS` cells per radius.

    Parameters
    ----------
    passed
        Where lines of sight cross the disc's plane, shape (m, 2).
    centre
        Of the disc, shape (2,).
    radius
        Metres.
    """
    cell = np.floor((passed - centre) / radius * CELLS)
    inside = (np.abs(cell + 0.5) < CELLS).all(axis=1)
    seen = np.zeros((2 * CELLS, 2 * CELLS), dtype=bool)
    seen[tuple((cell[inside].astype(np.intp) + CELLS).T)] = True
    middle = np.arange(2 * CELLS) + 0.5 - CELLS
    disc = middle[:, None] ** 2 + middle**2 < CELLS**2
    return float(seen[disc].mean())


def image_border(points: Points) -> Points:
    """Return the outermost `EDGE` pixels, shape (n, 3); n = 0 if the points are not an organised image."""
    if points.ndim < 3 or min(points.shape[:2]) <= 2 * EDGE:
        return np.empty((0, 3))
    bands = points[:EDGE], points[-EDGE:], points[:, :EDGE], points[:, -EDGE:]
    return np.concatenate([band.reshape(-1, 3) for band in bands])


def within_gap(a: Points, b: Points, gap: float) -> bool:
    """Whether any point of `a`, shape (n, 3), lies within `gap` of one of `b`, shape (m, 3)."""
    return any(bool((((b - point) ** 2).sum(axis=1) < gap**2).any()) for point in a)
