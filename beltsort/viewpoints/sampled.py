"""Sampling of the half-sphere, reachability and choice: how a map of viewpoints is made."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from beltsort import ArgumentError
from beltsort.errors import ViewpointError
from beltsort.geometry import Pose, direction_of, look_at
from beltsort.viewpoints.choice import well_spread
from beltsort.viewpoints.graph import neighbour_edges
from beltsort.viewpoints.map import ViewpointMap
from beltsort.viewpoints.sphere import Sampling

LOWEST = 15.0

Reachable = Callable[[Pose], bool]
"""Whether the arm can bring the camera to a pose `world_from_camera`, shape (4, 4)."""


def map_viewpoints(
    sampling: Sampling | None = None,
    viewpoints: int | Sequence[int] = 3,
    *,
    reachable: Reachable | None = None,
    lowest: float = LOWEST,
    note: str = "",
    neighbours_only: bool = False,
) -> ViewpointMap:
    """Sample the half-sphere, drop what is unreachable, connect neighbours and choose viewpoints.

    Parameters
    ----------
    sampling
        Default: 100 Fibonacci points at 0.7 m.
    viewpoints
        K, chosen far from each other (`choice.well_spread`), or the indices of the points to choose. They are
        named p1, p2, ... in that order.
    reachable
        Called for each point not below `lowest`, with `world_from_camera` of a camera that stands there and
        has the belt end in its centre; default: everything is reachable.
    lowest
        Elevation in degrees below which no point counts as reachable: the camera would see cups, not objects.
    note
        A remark on the arm, for the file.
    neighbours_only
        Whether one move only reaches a viewpoint's own neighbours.

    Raises
    ------
    ArgumentError
        If more viewpoints are asked for than points are reachable, or fewer than one.
    ViewpointError
        If nothing is reachable, the graph falls into parts, or a point that is asked for is not reachable.

    Examples
    --------
    >>> views = map_viewpoints(Sampling(count=40), reachable=lambda pose: bool(pose[0, 3] > 0.0))
    >>> [abs(viewpoint.azimuth) < 90.0 for viewpoint in views.viewpoints]
    [True, True, True]
    """
    sampling = sampling or Sampling()
    points = sampling.points()
    reached: NDArray[np.bool_] = direction_of(points)[1] >= lowest
    if reachable is not None:
        belt_end = np.zeros(3)
        for index in np.flatnonzero(reached):
            reached[index] = reachable(look_at(points[index], belt_end))
    if not reached.any():
        raise ViewpointError(
            f"none of the {sampling.count} points is reachable at {sampling.radius} m from the belt end and "
            f"{lowest} degrees or more above the belt; move the arm's base, or change radius or lowest"
        )
    if isinstance(viewpoints, int):
        among = np.flatnonzero(reached).tolist()
        if not 1 <= viewpoints <= len(among):
            raise ArgumentError(
                f"{viewpoints} viewpoints, expected from 1 to {len(among)}, the number of reachable points; "
                "choose fewer or sample more"
            )
        viewpoints = well_spread(points, among, viewpoints)
    return ViewpointMap(
        points=points,
        reachable=reached,
        edges=neighbour_edges(points, reached),
        chosen=tuple(viewpoints),
        names=tuple(f"p{k + 1}" for k in range(len(viewpoints))),
        sampling=sampling,
        lowest=lowest,
        note=note,
        neighbours_only=neighbours_only,
    )
