"""Choice of points that are far from each other."""

from collections.abc import Sequence

import numpy as np

from beltsort.geometry import Points


def well_spread(points: Points, among: Sequence[int], count: int) -> list[int]:
    """Choose `count` points far from each other: the highest first, then always the farthest.

    The next point is the one whose nearest chosen point is farthest away, the first of equals. The smallest
    angle between chosen points is at least half of the largest possible for that many points [1]_.

    Parameters
    ----------
    points
        On a sphere about the origin, shape (n, 3).
    among
        Indices of those that may be chosen, at least `count`.
    count
        K.

    Returns
    -------
    list of int
        Indices into `points`, in the order of their choice.

    References
    ----------
    .. [1] T. F. Gonzalez, "Clustering to minimize the maximum intercluster distance", Theoretical Computer
       Science 38 (1985) 293-306.

    Examples
    --------
    >>> points = np.array([[1.0, 0.0, 0.0], [0.8, 0.0, 0.6], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]])
    >>> well_spread(points, [0, 1, 2, 3], count=3)
    [2, 0, 3]
    """
    candidates = np.asarray(among)
    directions = points[candidates] / np.linalg.norm(points[candidates], axis=-1, keepdims=True)
    chosen = [int(np.argmax(directions[:, 2]))]
    nearness = directions @ directions[chosen[0]]
    while len(chosen) < count:
        nearness[chosen] = np.inf
        chosen.append(int(np.argmin(nearness)))
        nearness = np.maximum(nearness, directions @ directions[chosen[-1]])
    return [int(candidates[i]) for i in chosen]
