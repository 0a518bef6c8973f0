"""Observation tables with their intervals, as a picture."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from beltsort.tables.counts import Array, Counts
from beltsort.tables.intervals import credible_intervals
from beltsort.util.extras import extra
from beltsort.util.text import position_number

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.image import AxesImage

COLOURS = "cividis"  # lightness grows evenly: readable for colour-blind readers and in grey
DARK = 0.55  # below it, text is white
INCHES = 0.95  # of one entry


def draw_tables(
    counts: Counts,
    smoothing: float | Array,
    classes: Sequence[str],
    viewpoints: Sequence[str],
    path: Path,
    labels: Sequence[str] | None = None,
) -> None:
    """Draw a panel for each position and viewpoint: a row per true class, each entry with its 95 % interval.

    Parameters
    ----------
    counts, smoothing
        The table.
    classes, viewpoints
        Names.
    path
        The picture; its ending (png, svg, pdf) is its format.
    labels
        Names of the Z labels; default: the classes.
    """
    with extra("plot"):
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

    mean = counts.probabilities(smoothing)
    lower, upper = credible_intervals(counts, smoothing)
    positions, columns, rows, entries = mean.shape
    inches = (INCHES * entries + 0.9, INCHES * rows + 0.9)
    figure = Figure(figsize=(columns * inches[0] + 1.0, positions * inches[1]), layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(positions, columns, squeeze=False)
    for j in range(positions):
        for k in range(columns):
            image = _draw_panel(panels[j, k], mean[j, k], lower[j, k], upper[j, k])
            _name_axes(
                panels[j, k], classes, labels or classes, f"position {position_number(j)}, {viewpoints[k]}"
            )
    figure.colorbar(image, ax=panels, label="p(observed | true)", shrink=0.8)
    figure.savefig(path, dpi=120)


def _draw_panel(panel: "Axes", mean: Array, lower: Array, upper: Array) -> "AxesImage":
    image = panel.imshow(mean, cmap=COLOURS, vmin=0.0, vmax=1.0)
    for true, row in enumerate(mean):
        for observed, p in enumerate(row):
            ends = f"{lower[true, observed]:.2f}\u2013{upper[true, observed]:.2f}"
            colour = "white" if p < DARK else "black"
            panel.text(observed, true - 0.1, f"{p:.2f}", ha="center", va="center", color=colour)
            panel.text(observed, true + 0.22, ends, ha="center", va="center", color=colour, fontsize=7)
    return image


def _name_axes(panel: "Axes", classes: Sequence[str], labels: Sequence[str], title: str) -> None:
    panel.set_xticks(range(len(labels)), labels, rotation=30, ha="right")
    panel.set_yticks(range(len(classes)), classes)
    panel.set(title=title, xlabel="observed", ylabel="true")
