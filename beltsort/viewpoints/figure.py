"""The sampled half-sphere with its neighbour graph and viewpoints, as in the paper's Fig. 1."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from beltsort.geometry import Points
from beltsort.util.colours import COLOURS
from beltsort.util.extras import extra
from beltsort.viewpoints import ViewpointMap

REACHABLE, CHOSEN = COLOURS[0], COLOURS[1]
UNREACHABLE, EDGE, HELP_LINE = "0.5", "0.7", "0.88"
ELEVATIONS = (0, 30, 60)  # degrees
SEEN_FROM = (25.0, -60.0)  # elevation and azimuth, degrees


def draw_sphere(views: ViewpointMap, path: Path) -> None:
    """Draw a map of viewpoints in perspective and from above.

    In both panels unreachable points are grey crosses, reachable ones circles, viewpoints labelled squares.

    Parameters
    ----------
    views
        The map.
    path
        The picture; its ending (png, svg, pdf) is its format.
    """
    with extra("plot"):
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

    figure = Figure(figsize=(13.0, 6.4))
    FigureCanvasAgg(figure)
    solid: Any = figure.add_subplot(1, 2, 1, projection="3d", computed_zorder=False)
    above = figure.add_subplot(1, 2, 2)
    _draw_solid(solid, views)
    _draw_above(above, views)
    figure.legend(*above.get_legend_handles_labels(), loc="lower center", ncols=3)
    figure.subplots_adjust(left=0.0, right=0.98, bottom=0.17, top=0.93, wspace=0.1)
    figure.savefig(path, dpi=120)


def _draw_solid(panel: Any, views: ViewpointMap) -> None:
    radius = views.sampling.radius
    _draw_map(panel, views, views.points, depthshade=False)
    for elevation in ELEVATIONS:
        height = radius * np.sin(np.radians(elevation))
        panel.plot(*_circle(radius, elevation), height, color=HELP_LINE, linewidth=0.8)
    panel.plot([0.0, radius], [0.0, 0.0], [0.0, 0.0], color="black", linewidth=1.5)
    panel.text(0.0, 0.0, 0.0, "belt end", ha="right", va="top")
    panel.set(xlabel="x, upstream (m)", ylabel="y (m)", zlabel="z (m)", title="from the side")
    panel.set(xlim=(-radius, radius), ylim=(-radius, radius), zlim=(0.0, radius))
    panel.set_box_aspect((2.0, 2.0, 1.0))
    panel.view_init(*SEEN_FROM)


def _draw_above(panel: Any, views: ViewpointMap) -> None:
    radius = views.sampling.radius
    _draw_map(panel, views, views.points[:, :2])
    for elevation in ELEVATIONS:
        x, y = _circle(radius, elevation)
        panel.plot(x, y, color=HELP_LINE, linewidth=0.8, zorder=0)
        panel.annotate(f"{elevation}°", (0.0, y.min()), ha="center", va="bottom", fontsize=8, color="0.4")
    panel.plot([0.0, radius], [0.0, 0.0], color="black", linewidth=1.5, zorder=0)
    panel.annotate("belt end", (0.0, 0.0), ha="right", va="top")
    panel.set(xlabel="x, upstream (m)", ylabel="y (m)", title="from above, with circles of equal elevation")
    panel.set_aspect("equal")


def _circle(radius: float, elevation: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return x and y of a circle of equal elevation (degrees)."""
    turn, across = np.linspace(0.0, 2.0 * np.pi, 181), radius * np.cos(np.radians(elevation))
    return across * np.cos(turn), across * np.sin(turn)


def _draw_map(panel: Any, views: ViewpointMap, shown: Points, **shading: bool) -> None:
    """Draw edges, points and names at `shown`, shape (n, 2) or (n, 3)."""
    for pair in views.edges:
        panel.plot(*shown[pair].T, color=EDGE, linewidth=0.8, zorder=1)
    chosen = np.isin(np.arange(len(shown)), views.chosen)
    free = views.reachable & ~chosen
    panel.scatter(
        *shown[~views.reachable].T, label="unreachable", marker="x", color=UNREACHABLE, s=20, **shading
    )
    panel.scatter(
        *shown[free].T, label="reachable", facecolor="white", edgecolor=REACHABLE, s=24, zorder=2, **shading
    )
    panel.scatter(
        *shown[chosen].T, label="viewpoint", marker="s", color=CHOSEN, edgecolor="black", s=70, zorder=3,
        **shading,
    )  # fmt: skip
    for index, name in zip(views.chosen, views.names, strict=True):
        panel.text(*shown[index], f"  {name}", va="bottom", fontsize=11, fontweight="bold", zorder=4)
