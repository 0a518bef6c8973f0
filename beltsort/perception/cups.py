"""Where along the belt cups stand, found by their rims.

A rim is a circle of known radius at a known height. Each place along the belt is scored by the share of the
circle about it on which points are seen; the places of cups are the best ones, none within a cup's width of
another. A least-squares fit of the circle then gives the place to a fraction of a voxel.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from beltsort.errors import CloudError
from beltsort.geometry import BeltLayout, Points, transform
from beltsort.perception.clean import voxel_means
from beltsort.perception.config import PerceptionConfig
from beltsort.perception.segment import DepthScan, View

STEP = 0.002  # metres between the places scored
ACROSS = (-0.006, -0.003, 0.0, 0.003, 0.006)  # metres beside the belt's middle, by which an arm errs
BAND = 0.005  # metres above and below the rim's height
INSIDE, OUTSIDE = 0.006, 0.003  # metres within and beyond the rim's radius that count as the rim
SECTORS = 24  # of the circle
LEAST_SHARE = 0.3  # of the sectors; objects hide much of a rim, and a camera from the side sees half of it
FITS = 4  # Gauss-Newton steps


@dataclass(frozen=True)
class FoundCup:
    """A cup found by its rim.

    Attributes
    ----------
    place
        Its x in the world frame, metres.
    seen
        Share of its rim that the scan shows, from 0 to 1.
    """

    place: float
    seen: float


def find_cups(
    scan: DepthScan, layout: BeltLayout, config: PerceptionConfig | None = None
) -> tuple[FoundCup, ...]:
    """Return the cups that a scan shows, in order along the belt, the most downstream first.

    Parameters
    ----------
    scan
        As in `segment`; its pose is corrected in the same way.
    layout
        Height and radius of the rims; its positions are not used.
    config
        Settings; default `PerceptionConfig()`.

    Raises
    ------
    CloudError
        As `segment`, or if the rims are no higher than `BAND`, so that the belt would be taken for rims.
    """
    if layout.rim_height <= BAND:
        raise CloudError(
            f"rim_height is {layout.rim_height} m, expected above {BAND}: cups are found by rims that stand "
            "out from the belt; give the places of the objects instead"
        )
    view = View.of(scan, layout, config or PerceptionConfig())
    rims = _rim_points(view)
    if len(rims) == 0:
        return ()
    along = np.arange(rims[:, 0].min() - layout.rim_radius, rims[:, 0].max() + layout.rim_radius, STEP)
    scores = np.array([_scores(rims, along, y, layout.rim_radius) for y in ACROSS])  # (across, along)
    best = scores.max(axis=0)
    across = np.array(ACROSS)[scores.argmax(axis=0)]
    found = []
    while best.max() >= LEAST_SHARE:
        # A maximum is flat: its middle is the best start.
        top = np.flatnonzero(
            (best == best.max()) & (np.abs(along - along[best.argmax()]) < layout.rim_radius)
        )
        chosen = int(top[len(top) // 2])
        place = _fitted(rims, np.array([along[chosen], across[chosen]]), layout.rim_radius)
        found.append(FoundCup(place, float(best[chosen])))
        best[np.abs(along - along[chosen]) < 2.0 * layout.rim_radius] = 0.0
    return tuple(sorted(found, key=lambda cup: cup.place))


def _rim_points(view: View) -> Points:
    """Return voxel means of the points at the rims' height near the belt's middle, shape (n, 2)."""
    with np.errstate(invalid="ignore"):
        at_rim = np.flatnonzero(np.abs(view.height - view.layout.rim_height) < BAND)
    world = transform(view.world_from_camera, view.points[at_rim])
    reach = view.layout.rim_radius + OUTSIDE + max(ACROSS)
    rims: Points = voxel_means(world[np.abs(world[:, 1]) < reach], view.config.voxel)[:, :2]
    return rims


def _scores(rims: Points, along: NDArray[np.float64], y: float, radius: float) -> NDArray[np.float64]:
    """Return the share of the circle about each place (x, y) on which points lie, shape (len(along),)."""
    dx, dy = rims[None, :, 0] - along[:, None], rims[None, :, 1] - y  # (places, points)
    place, point = np.nonzero(_on_rim(np.hypot(dx, dy), radius))
    angle = np.arctan2(np.broadcast_to(dy, dx.shape)[place, point], dx[place, point])
    sector = np.floor((angle + np.pi) / (2.0 * np.pi) * SECTORS).astype(np.intp) % SECTORS
    seen = np.zeros((len(along), SECTORS), dtype=bool)
    seen[place, sector] = True
    share: NDArray[np.float64] = seen.mean(axis=1)
    return share


def _on_rim(distance: NDArray[np.float64], radius: float) -> NDArray[np.bool_]:
    inside: NDArray[np.bool_] = (distance > radius - INSIDE) & (distance < radius + OUTSIDE)
    return inside


def _fitted(rims: Points, centre: Points, radius: float) -> float:
    """Return the x of the circle that fits the rim's points best, given its centre, shape (2,), roughly.

    The radius is that of the middle of the band, so that a rim seen on one side only is not displaced.
    """
    middle = radius + (OUTSIDE - INSIDE) / 2.0
    for _ in range(FITS):
        away = rims - centre
        distance = np.hypot(away[:, 0], away[:, 1])
        near = _on_rim(distance, radius)
        if near.sum() < 3:
            break
        normal = away[near] / distance[near, None]
        step, *_ = np.linalg.lstsq(normal, distance[near] - middle, rcond=None)
        centre = centre + step
    return float(centre[0])
