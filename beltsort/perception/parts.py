"""Whether the separate surfaces of a candidate are parts of one object, or several objects.

A camera sees an object in parts where it hides some of itself, or returns patchily, so the distance between
the parts alone says little: a bowl's near and far wall lie a bowl's width apart, two balls a finger's. Two
more things tell:

* The farther part is hollow towards the camera, and the nearer one faces away from the centre about which it
  curves. Then they are the inner and the outer wall of one object.
* The camera looks through between the parts, on what lies below the rims, and so nothing joins them there.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from beltsort import _core
from beltsort.geometry import Points
from beltsort.perception.config import PerceptionConfig
from beltsort.perception.descriptor import oriented_normals
from beltsort.util.extras import extra

SEEN_THROUGH = 0.5  # share of the lines across a gap that lines of sight pass
HOLLOW = -0.1  # convexity; inner walls of real bowls and cups have -0.2 to -0.6, balls 0.2 to 0.8
OUTWARDS = 0.6  # cosine; outer walls have 0.63 and more, a second object beside a hollow one 0.6 and less
LINES = 0.1  # share of a part's points from which lines across the gap start, those nearest to the other part
FEWEST_LINES = 5
WIDER = 0.01  # metres by which such a line may be longer than the shortest
BESIDE = 0.003  # metres from the middle of a line to a line of sight that passes it


@dataclass(frozen=True, eq=False)
class Background:
    """What a camera sees below the objects.

    Attributes
    ----------
    eye
        The camera's position, shape (3,), world frame, metres.
    level
        Height, metres above the belt, above which objects are.
    passed
        Where lines of sight that end below `level` cross it, shape (m, 2), as `crossings` returns it.
    """

    eye: Points
    level: float
    passed: Points

    def seen_past(self, points: Points) -> NDArray[np.bool_]:
        """Return which points above `level`, shape (n, 3), lie on a line of sight that ends below, (n,)."""
        with extra("perception"):
            from scipy.spatial import cKDTree

        if len(self.passed) == 0:
            return np.zeros(len(points), dtype=bool)
        towards = (self.eye[2] - self.level) / (self.eye[2] - points[:, 2])  # 1 at the level, more below it
        crossing = self.eye[:2] + towards[:, None] * (points[:, :2] - self.eye[:2])
        distance, _ = cKDTree(self.passed).query(crossing)
        return np.asarray(distance < BESIDE * towards)


@dataclass(frozen=True, eq=False)
class Part:
    """One of the surfaces of a candidate.

    Attributes
    ----------
    points
        Shape (n, 3), world frame, metres.
    normals
        On the camera's side, shape (n, 3).
    """

    points: Points
    normals: Points

    @cached_property
    def mean(self) -> Points:
        """Mean of the points, shape (3,)."""
        mean: Points = self.points.mean(axis=0)
        return mean

    @cached_property
    def _covariance(self) -> float:
        """Mean of (p - m) . n over points p with normals n, and their mean m."""
        return float(np.einsum("ij,ij->i", self.points - self.mean, self.normals).mean())

    @property
    def convexity(self) -> float:
        """The mean of (p - m) . n divided by that of |p - m|: 0 for a plane, negative if hollow."""
        return self._covariance / float(np.linalg.norm(self.points - self.mean, axis=1).mean())

    @property
    def centre(self) -> Points:
        """The centre c of a hollow surface, for which p + r n = c fits best with some r, shape (3,)."""
        mean_normal = self.normals.mean(axis=0)
        spread = np.square(self.normals - mean_normal).sum(axis=1).mean()
        centre: Points = self.mean - self._covariance / spread * mean_normal
        return centre

    def outwards(self, centre: Points) -> float:
        """Return the mean cosine between the normals and the directions away from `centre`, shape (3,)."""
        away = self.points - centre
        along = np.einsum("ij,ij->i", away, self.normals)
        return float((along / np.linalg.norm(away, axis=1)).mean())


def several_objects(points: Points, background: Callable[[], Background], config: PerceptionConfig) -> bool:
    """Whether a candidate has parts that no single object has.

    Parameters
    ----------
    points
        The candidate, shape (n, 3), world frame, metres.
    background
        Returns what the camera sees below the objects; called only if there is more than one large part.
    config
        Settings: parts are clusters by `cluster_gap`. Those of `fewest_labelled` points or more may be
        objects; if they are farther apart than `object_gap`, they are several unless they are walls of one.
    """
    cluster = _core.clusters(points, config.cluster_gap)
    sizes = np.bincount(cluster, minlength=1)
    large = np.flatnonzero(sizes >= config.fewest_labelled)
    if len(large) < 2:
        return False
    below = background()
    normals = oriented_normals(points, below.eye, config.normal_neighbours)
    parts = [Part(points[cluster == k], normals[cluster == k]) for k in range(len(sizes))]
    apart, waiting = set(range(len(parts))) - {int(large[0])}, [int(large[0])]
    while waiting:
        part = parts[waiting.pop()]
        joined = {k for k in apart if _one_object(part, parts[k], below, config)}
        apart -= joined
        waiting += sorted(joined)
    return not apart.isdisjoint(large.tolist())


def _one_object(a: Part, b: Part, background: Background, config: PerceptionConfig) -> bool:
    """Whether two parts belong together, as far as these two tell."""
    gap, middles = _gap(a, b)
    if min(len(a.points), len(b.points)) < config.fewest_labelled:
        return gap <= config.object_gap
    if _walls_of_one(a, b, background.eye):
        return True
    return gap <= config.object_gap and background.seen_past(middles).mean() < SEEN_THROUGH


def _walls_of_one(a: Part, b: Part, eye: Points) -> bool:
    """Whether two parts can be the outer and the inner wall of a hollow object."""
    near, far = sorted((a, b), key=lambda part: float(np.linalg.norm(part.mean - eye)))
    return far.convexity < HOLLOW and near.outwards(far.centre) >= OUTWARDS


def _gap(a: Part, b: Part) -> tuple[float, Points]:
    """Return the distance of two parts, and the middles of the shortest lines between them, shape (n, 3)."""
    with extra("perception"):
        from scipy.spatial import cKDTree

    lengths, nearest = cKDTree(b.points).query(a.points)
    order = np.argsort(lengths, kind="stable")[: max(FEWEST_LINES, int(LINES * len(lengths)))]
    shortest = float(lengths[order[0]])
    lines = order[lengths[order] < shortest + WIDER]
    return shortest, (a.points[lines] + b.points[nearest[lines]]) / 2.0
