"""What must hold of a viewpoint map, and what to do where it does not."""

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from beltsort.errors import ViewpointError
from beltsort.viewpoints.graph import components

if TYPE_CHECKING:
    from beltsort.viewpoints.map import ViewpointMap

OFF_SPHERE = 1e-6  # metres
LISTED = 8


def check_map(views: "ViewpointMap") -> None:
    """Refuse points off the half-sphere, edges and viewpoints without a reachable point, graphs in parts."""
    _check_points(views)
    _check_edges(views)
    _check_chosen(views)
    _check_connected(views)
    if views.neighbours_only:
        _check_travel(views)


def listed(things: Iterable[object], separator: str = ", ") -> str:
    """Return the first few of many things as text."""
    texts = [str(thing) for thing in things]
    more = len(texts) - LISTED
    return separator.join(texts[:LISTED]) + (f" and {more} more" if more > 0 else "")


def _check_points(views: "ViewpointMap") -> None:
    count, radius = views.sampling.count, views.sampling.radius
    for name, length in (("points", len(views.points)), ("reachable", len(views.reachable))):
        if length != count:
            raise ViewpointError(f"{name} has {length} entries, expected {count}, the sampling's count")
    if not 0.0 <= views.lowest <= 90.0:
        raise ViewpointError(f"lowest is {views.lowest}, expected an elevation from 0 to 90 degrees")
    off = np.abs(np.linalg.norm(views.points, axis=-1) - radius) > OFF_SPHERE
    wrong = np.flatnonzero(~np.isfinite(views.points).all(axis=-1) | off | (views.points[:, 2] < 0.0))
    if wrong.size:
        raise ViewpointError(
            f"points[{wrong[0]}] is {views.points[wrong[0]].tolist()}, expected a point of the upper "
            f"half-sphere of radius {radius} m; sample it anew"
        )


def _check_edges(views: "ViewpointMap") -> None:
    count = len(views.points)
    for i, j in views.edges.tolist():
        if not (0 <= i < j < count and views.reachable[i] and views.reachable[j]):
            raise ViewpointError(
                f"edges has the pair ({i}, {j}), expected two reachable points below {count}, the smaller "
                "index first; sample the graph anew"
            )


def _check_chosen(views: "ViewpointMap") -> None:
    _check_names(views.names, len(views.chosen))
    if len(set(views.chosen)) < len(views.chosen):
        raise ViewpointError(f"the chosen points are {list(views.chosen)}, expected none twice")
    for index in views.chosen:
        if not 0 <= index < len(views.points) or not views.reachable[index]:
            raise ViewpointError(
                f"point {index} is chosen, expected a reachable one: choose from "
                f"{listed(np.flatnonzero(views.reachable).tolist())}"
            )


def _check_names(names: Sequence[str], count: int) -> None:
    if len(names) != count or count == 0 or len(set(names)) < count or not all(names):
        raise ViewpointError(
            f"names are {list(names)} for {count} chosen points, expected at least one point and a name for "
            "each, none empty, none twice"
        )


def _check_connected(views: "ViewpointMap") -> None:
    nodes = np.flatnonzero(views.reachable).tolist()
    parts = components(nodes, views.edges, len(views.points))
    if len(parts) > 1:
        names = listed((f"{len(part)} points: {listed(part)}" for part in parts), "; ")
        raise ViewpointError(
            f"the neighbour graph falls into {len(parts)} parts ({names}), expected one; sample more points "
            "or move the arm's base, so that the gap closes"
        )


def _check_travel(views: "ViewpointMap") -> None:
    """Refuse viewpoints that are never reached by moves between neighbours."""
    edges = np.argwhere(np.triu(views.steps() <= 1.0, 1))
    groups = components(range(len(views.chosen)), edges, len(views.chosen))
    if len(groups) > 1:
        names = listed((listed(views.names[k] for k in group) for group in groups), "; ")
        raise ViewpointError(
            f"with neighbours_only no move leads from one of these groups of viewpoints to another: {names}; "
            "choose more of the points, sample fewer, or allow all moves"
        )
