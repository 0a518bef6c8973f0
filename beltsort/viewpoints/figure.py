"""The sampled half-sphere with its neighbour graph and viewpoints, as in the paper's Fig. 1."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from beltsort.geometry import Points
from beltsort.util.colours import COLOURS
from beltsort.util.figure_style import DPI, PAGE, column_style, empty_figure
from beltsort.viewpoints import ViewpointMap

if TYPE_CHECKING:
    from matplotlib.figure import Figure

REACHABLE, CHOSEN = COLOURS[0], COLOURS[1]
UNREACHABLE, EDGE, HELP_LINE = "0.5", "0.7", "0.88"
ELEVATIONS = (0, 30, 60)  # degrees
SEEN_FROM = (25.0, -60.0)  # elevation and azimuth, degrees


def draw_sphere(views: ViewpointMap, path: Path) -> None:
    """Draw a map of viewpoints into a file, as in `sphere_figure`.

    Parameters
    ----------
    views
        The map.
    path
        The picture; its ending (png, svg, pdf) is its format.
    """
    sphere_figure(views).savefig(path, dpi=DPI)


@column_style()
def sphere_figure(views: ViewpointMap) -> "Figure":
    """Draw a map of viewpoints in perspective and from above, two columns wide.

    In both panels unreachable points are grey crosses, reachable ones circles, viewpoints labelled squares.
    """
    figure = empty_figure(PAGE, 3.5)
    figure.set_layout_engine(None)  # a solid panel has wide empty margins, which no layout engine uses
    solid: Any = figure.add_axes((0.0, 0.08, 0.53, 0.92), projection="3d", computed_zorder=False)
    above = figure.add_axes((0.61, 0.18, 0.38, 0.76))
    _draw_solid(solid, views)
    _draw_above(above, views)
    figure.legend(*above.get_legend_handles_labels(), loc="lower center", ncols=3)
    return figure


def _draw_solid(panel: Any, views: ViewpointMap) -> None:
    radius = views.sampling.radius
    _draw_map(panel, views, views.points, depthshade=False)
    for elevation in ELEVATIONS:
        height = radius * np.sin(np.radians(elevation))
        panel.plot(*_circle(radius, elevation), height, color=HELP_LINE, linewidth=0.5)
    panel.plot([0.0, radius], [0.0, 0.0], [0.0, 0.0], color="black", linewidth=1.0)
    panel.text(0.0, 0.0, 0.0, "belt end", ha="right", va="top")
    panel.set(xlabel="x, upstream (m)", ylabel="y (m)", zlabel="z (m)")
    panel.set_title("from the side", y=0.98)
    panel.locator_params(nbins=5)
    panel.tick_params(pad=-3.0)
    for axis in (panel.xaxis, panel.yaxis, panel.zaxis):
        axis.labelpad = -8.0
    panel.set(xlim=(-radius, radius), ylim=(-radius, radius), zlim=(0.0, radius))
    panel.set_box_aspect((2.0, 2.0, 1.0), zoom=0.93)
    panel.view_init(*SEEN_FROM)


def _draw_above(panel: Any, views: ViewpointMap) -> None:
    radius = views.sampling.radius
    _draw_map(panel, views, views.points[:, :2])
    for elevation in ELEVATIONS:
        x, y = _circle(radius, elevation)
        panel.plot(x, y, color=HELP_LINE, linewidth=0.5, zorder=0)
        panel.annotate(f"{elevation}°", (0.0, y.min()), ha="center", va="bottom", color="0.4")
    panel.plot([0.0, radius], [0.0, 0.0], color="black", linewidth=1.0, zorder=0)
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
        panel.plot(*shown[pair].T, color=EDGE, linewidth=0.5, zorder=1)
    chosen = np.isin(np.arange(len(shown)), views.chosen)
    free = views.reachable & ~chosen
    panel.scatter(
        *shown[~views.reachable].T,
        label="unreachable",
        marker="x",
        color=UNREACHABLE,
        s=7,
        linewidth=0.7,
        **shading,
    )
    panel.scatter(
        *shown[free].T,
        label="reachable",
        facecolor="white",
        edgecolor=REACHABLE,
        s=9,
        linewidth=0.7,
        zorder=2,
        **shading,
    )
    panel.scatter(
        *shown[chosen].T, label="viewpoint", marker="s", color=CHOSEN, edgecolor="black", s=26, zorder=3,
        **shading,
    )  # fmt: skip
    for index, name in zip(views.chosen, views.names, strict=True):
        panel.text(*shown[index], f"  {name}", va="bottom", fontweight="bold", zorder=4)
