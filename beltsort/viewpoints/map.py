"""A map of viewpoints: the sampled half-sphere, its neighbour graph and the chosen points."""

from collections.abc import Iterable
from dataclasses import asdict, dataclass
from os import PathLike
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import NDArray

from beltsort import BeltsortError
from beltsort.errors import ViewpointError
from beltsort.geometry import Points, SphereViewpoint, direction_of
from beltsort.util.html import box, table
from beltsort.util.text import text_table
from beltsort.viewpoints.graph import Edges, components, steps_from
from beltsort.viewpoints.sphere import Sampling

if TYPE_CHECKING:
    from beltsort.viewpoints.file import ViewpointFile

OFF_SPHERE = 1e-6  # metres
LISTED = 8


@dataclass(frozen=True, eq=False)
class ViewpointMap:
    """Sampled points of the half-sphere, their neighbour graph, and the K points chosen as viewpoints.

    Between two viewpoints the camera goes from neighbour to neighbour: a move costs the number of edges on
    the shortest path, and 1 where it stays, since a second scan from the same place is one step too.

    Attributes
    ----------
    points
        Camera positions, world frame, metres, shape (n, 3).
    reachable
        Which of them the arm reaches, shape (n,).
    edges
        Pairs of neighbours, smaller index first, shape (m, 2).
    chosen
        Index of each viewpoint's point, K of them.
    names
        Of the viewpoints.
    sampling, lowest, note
        How it was made: the sampling, the elevation in degrees below which no point counted as reachable, and
        a remark on the arm.
    neighbours_only
        Whether one move only reaches a viewpoint's own neighbours.

    Raises
    ------
    ViewpointError
        If the parts contradict each other, the graph falls into parts, or, with `neighbours_only`, some
        viewpoint is never reached.

    Examples
    --------
    >>> from beltsort.viewpoints import Sampling, map_viewpoints
    >>> views = map_viewpoints(Sampling(count=40), viewpoints=3)
    >>> views.motion_cost.tolist()
    [[1.0, 4.0, 4.0], [4.0, 1.0, 3.0], [4.0, 3.0, 1.0]]

    A simulated cell with these viewpoints, and a model of it:

    >>> import beltsort
    >>> from beltsort.sim import CellConfig
    >>> config = CellConfig(viewpoints=views.viewpoints)
    >>> p_obs = np.full((2, 3, 4, 4), 0.25)
    >>> model = beltsort.SortingModel(config.classes, p_obs=p_obs, **views.model_settings())
    >>> float(model.motion_cost[1, 2])
    3.0
    """

    points: Points
    reachable: NDArray[np.bool_]
    edges: Edges
    chosen: tuple[int, ...]
    names: tuple[str, ...]
    sampling: Sampling
    lowest: float
    note: str = ""
    neighbours_only: bool = False

    def __post_init__(self) -> None:
        """Check that points, edges and viewpoints fit together and that the graph is connected."""
        _check_points(self)
        _check_edges(self)
        _check_chosen(self)
        _check_connected(self)
        if self.neighbours_only:
            _check_travel(self)

    def __repr__(self) -> str:
        """Return the chosen viewpoints with their directions and the costs of moves."""
        return f"{self._title()}\n{text_table([self._header(), *self._rows()])}"

    def _repr_html_(self) -> str:
        """Return HTML for notebooks."""
        return box(self._title(), table(self._rows(), header=self._header()))

    def _title(self) -> str:
        points = f"{len(self.points)} points, {int(self.reachable.sum())} of them reachable"
        moves = ", moves to neighbours only" if self.neighbours_only else ""
        return f"ViewpointMap: {len(self.chosen)} viewpoints of {points}{moves}"

    def _header(self) -> list[str]:
        return ["viewpoint", "azimuth", "elevation", *(f"to {name}" for name in self.names)]

    def _rows(self) -> list[list[str]]:
        return [
            [view.name, f"{view.azimuth:.1f}", f"{view.elevation:.1f}", *(f"{cost:g}" for cost in costs)]
            for view, costs in zip(self.viewpoints, self.motion_cost.tolist(), strict=True)
        ]

    @property
    def viewpoints(self) -> tuple[SphereViewpoint, ...]:
        """The chosen viewpoints, as the simulated cell's configuration takes them."""
        azimuths, elevations = direction_of(self.points[list(self.chosen)])
        return tuple(
            SphereViewpoint(name, float(azimuth), float(elevation), self.sampling.radius)
            for name, azimuth, elevation in zip(self.names, azimuths, elevations, strict=True)
        )

    @property
    def motion_cost(self) -> NDArray[np.float64]:
        """Cost of each move `[from, to]` in planner steps, shape (K, K): a metric, but staying costs 1."""
        cost = self.steps()
        np.fill_diagonal(cost, 1.0)
        return cost

    @property
    def travel(self) -> list[list[int]]:
        """The viewpoints that one move reaches, ascending, by viewpoint; each reaches itself."""
        near = self.steps() <= (1.0 if self.neighbours_only else np.inf)
        return [np.flatnonzero(row).tolist() for row in near]

    def model_settings(self) -> dict[str, Any]:
        """Return keyword arguments for `beltsort.SortingModel`: viewpoints, motion_cost and travel."""
        return {"viewpoints": list(self.names), "motion_cost": self.motion_cost, "travel": self.travel}

    def steps(self) -> NDArray[np.float64]:
        """Return the number of edges on the shortest path between viewpoints, shape (K, K), or infinity."""
        chosen = list(self.chosen)
        return np.array([steps_from(start, self.edges, len(self.points))[chosen] for start in chosen])

    def save(self, path: str | PathLike[str]) -> None:
        """Write it to a JSON file; an existing one is replaced."""
        self._file().write(path)

    @classmethod
    def load(cls, path: str | PathLike[str]) -> Self:
        """Read a file that `save` wrote.

        Raises
        ------
        ViewpointError
            If the file cannot be read, has unknown or missing keys or values of a wrong type, or contradicts
            itself.
        """
        from beltsort.viewpoints.file import ViewpointFile

        try:
            file = ViewpointFile.read(path)
            graph = file.graph
            views = cls(
                points=np.array(graph.points, dtype=np.float64).reshape(-1, 3),
                reachable=np.array(graph.reachable, dtype=np.bool_),
                edges=np.array(graph.edges, dtype=np.int64).reshape(-1, 2),
                chosen=tuple(viewpoint.point for viewpoint in file.viewpoints),
                names=tuple(viewpoint.name for viewpoint in file.viewpoints),
                sampling=Sampling(**file.sampling.model_dump()),
                lowest=file.lowest,
                note=file.note,
                neighbours_only=file.neighbours_only,
            )
            file.check_against(views._file())
        except BeltsortError as reason:
            raise ViewpointError(f"{path}: {reason}") from reason
        return views

    def _file(self) -> "ViewpointFile":
        """Return the content of its file."""
        from beltsort.viewpoints.file import GraphEntry, SamplingEntry, ViewpointEntry, ViewpointFile

        return ViewpointFile(
            viewpoints=[
                ViewpointEntry(
                    name=viewpoint.name,
                    point=index,
                    position=self.points[index].tolist(),
                    world_from_camera=viewpoint.pose().tolist(),
                )
                for viewpoint, index in zip(self.viewpoints, self.chosen, strict=True)
            ],
            motion_cost=self.motion_cost.tolist(),
            travel=self.travel,
            sampling=SamplingEntry(**asdict(self.sampling)),
            lowest=self.lowest,
            note=self.note,
            neighbours_only=self.neighbours_only,
            graph=GraphEntry(
                points=self.points.tolist(), reachable=self.reachable.tolist(), edges=self.edges.tolist()
            ),
        )


def _listed(things: Iterable[object], separator: str = ", ") -> str:
    """Return the first few of many things as text."""
    texts = [str(thing) for thing in things]
    more = len(texts) - LISTED
    return separator.join(texts[:LISTED]) + (f" and {more} more" if more > 0 else "")


def _check_points(views: ViewpointMap) -> None:
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


def _check_edges(views: ViewpointMap) -> None:
    count = len(views.points)
    for i, j in views.edges.tolist():
        if not (0 <= i < j < count and views.reachable[i] and views.reachable[j]):
            raise ViewpointError(
                f"edges has the pair ({i}, {j}), expected two reachable points below {count}, the smaller "
                "index first; sample the graph anew"
            )


def _check_chosen(views: ViewpointMap) -> None:
    names, count = views.names, len(views.chosen)
    if len(names) != count or count == 0 or len(set(names)) < count or not all(names):
        raise ViewpointError(
            f"names are {list(names)} for {count} chosen points, expected at least one point and a name for "
            "each, none empty, none twice"
        )
    if len(set(views.chosen)) < len(views.chosen):
        raise ViewpointError(f"the chosen points are {list(views.chosen)}, expected none twice")
    for index in views.chosen:
        if not 0 <= index < len(views.points) or not views.reachable[index]:
            raise ViewpointError(
                f"point {index} is chosen, expected a reachable one: choose from "
                f"{_listed(np.flatnonzero(views.reachable).tolist())}"
            )


def _check_connected(views: ViewpointMap) -> None:
    nodes = np.flatnonzero(views.reachable).tolist()
    parts = components(nodes, views.edges, len(views.points))
    if len(parts) > 1:
        names = _listed((f"{len(part)} points: {_listed(part)}" for part in parts), "; ")
        raise ViewpointError(
            f"the neighbour graph falls into {len(parts)} parts ({names}), expected one; sample more points "
            "or move the arm's base, so that the gap closes"
        )


def _check_travel(views: ViewpointMap) -> None:
    """Refuse viewpoints that are never reached by moves between neighbours."""
    edges = np.argwhere(np.triu(views.steps() <= 1.0, 1))
    groups = components(range(len(views.chosen)), edges, len(views.chosen))
    if len(groups) > 1:
        names = _listed((_listed(views.names[k] for k in group) for group in groups), "; ")
        raise ViewpointError(
            f"with neighbours_only no move leads from one of these groups of viewpoints to another: {names}; "
            "choose more of the points, sample fewer, or allow all moves"
        )
