"""The sampled half-sphere, its neighbour graph and the chosen viewpoints: what cell and model share."""

from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from beltsort import BeltsortError
from beltsort.errors import ViewpointError
from beltsort.geometry import Points, SphereViewpoint, direction_of
from beltsort.viewpoints.checks import check_map
from beltsort.viewpoints.file import check_repeated, parts_of, plain, read_plain, text_of
from beltsort.viewpoints.graph import Edges, steps_from
from beltsort.viewpoints.sphere import Sampling


@dataclass(frozen=True, eq=False)
class ViewpointMap:
    """Points of the half-sphere, which of them are reachable and neighbours, and the K chosen ones.

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
        How it was made: the sampling, the elevation in degrees below which nothing counted as reachable, and
        a word on the arm.
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
        """Refuse parts that contradict each other and graphs in parts."""
        check_map(self)

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
        """Planner steps' worth of each move `[from, to]`, shape (K, K): a metric but for the 1 of staying."""
        cost = self.steps()
        np.fill_diagonal(cost, 1.0)
        return cost

    @property
    def travel(self) -> list[list[int]]:
        """The viewpoints that one move reaches, ascending, by viewpoint; each reaches itself."""
        near = self.steps() <= (1.0 if self.neighbours_only else np.inf)
        return [np.flatnonzero(row).tolist() for row in near]

    def model_settings(self) -> dict[str, Any]:
        """Return what a `beltsort.SortingModel` needs to know: viewpoints, motion_cost and travel."""
        return {"viewpoints": list(self.names), "motion_cost": self.motion_cost, "travel": self.travel}

    def steps(self) -> NDArray[np.float64]:
        """Return the number of edges on the shortest path between viewpoints, shape (K, K), or infinity."""
        chosen = list(self.chosen)
        return np.array([steps_from(start, self.edges, len(self.points))[chosen] for start in chosen])

    def save(self, path: str | PathLike[str]) -> None:
        """Write it to a JSON file; an existing one is replaced."""
        Path(path).write_text(text_of(plain(self)))

    @classmethod
    def load(cls, path: str | PathLike[str]) -> Self:
        """Read a file that `save` wrote.

        Raises
        ------
        ViewpointError
            If the file cannot be read, has unknown keys, or what it says contradicts itself.
        """
        try:
            given = read_plain(Path(path))
            views = cls(**parts_of(given))
            check_repeated(given, plain(views))
        except BeltsortError as reason:
            raise ViewpointError(f"{path}: {reason}") from reason
        return views
