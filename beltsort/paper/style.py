"""The style of the report's figures: curves differ for colour-blind readers and in grey, too."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from beltsort.paper.outcomes import Row, estimate_in
from beltsort.paper.statistics import CONFIDENCE
from beltsort.util.colours import COLOURS, MARKERS
from beltsort.util.extras import extra
from beltsort.util.figure_style import COLUMN, DPI, column_style, empty_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LINES = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)))
FORMATS: dict[str, dict[str, Any]] = {".png": {}, ".svg": {"Date": None}, ".pdf": {"CreationDate": None}}
"""Formats of every figure, with the metadata that makes the same figure the same file."""
PALETTE = 128  # colours of a PNG
ROW = 1.05  # inches; height of a panel
ERROR_BARS = f"Error bars: {100 * CONFIDENCE:.0f} % confidence intervals of the mean"
LARGEST, SMALLER = 4.6, 0.7  # points; markers of the first curve, and by how much each further one is smaller
SMALLEST = 2.4
Look: TypeAlias = dict[str, Any]
"""Keywords of matplotlib's `plot`."""

PRINTED: Look = {
    "color": "black",
    "marker": "*",
    "linestyle": "none",
    "markersize": 6,
    "markeredgecolor": "white",
    "markeredgewidth": 0.4,
    "zorder": 5,
}
"""Style of the paper's own numbers."""


def style(number: int, *, filled: bool = True) -> Look:
    """Return colour, marker and line of the n-th curve of a figure.

    Markers get smaller from curve to curve, so that points at the same place are all seen.
    """
    colour = COLOURS[number % len(COLOURS)]
    return {
        "color": colour,
        "marker": MARKERS[number % len(MARKERS)],
        "linestyle": LINES[number % len(LINES)],
        "markerfacecolor": colour if filled else "white",
        "markersize": max(SMALLEST, LARGEST - SMALLER * number),
        "markeredgewidth": 0.7,
        "linewidth": 0.8,
        "elinewidth": 0.7,
        "capsize": 1.5,
        "capthick": 0.7,
    }


def new_figure(rows: int, columns: int, height: float = ROW, **shared: Any) -> "tuple[Figure, Any]":
    """Return a figure one column wide and its panels, shape (rows, columns).

    Parameters
    ----------
    rows, columns
        Number of panels.
    height
        Of a panel, inches.
    shared
        `sharex` and `sharey` of matplotlib's `subplots`.
    """
    figure = empty_figure(COLUMN, rows * height + 1.0)
    return figure, figure.subplots(rows, columns, squeeze=False, **shared)


def curve(panel: "Axes", x: Sequence[float], rows: Sequence[Row], outcome: str, **look: Any) -> None:
    """Draw means with their confidence intervals, a point per row of a plain table."""
    points = [estimate_in(row, outcome) for row in rows]
    half = [estimate.interval[1] - estimate.value for estimate in points]
    panel.errorbar(x, [estimate.value for estimate in points], yerr=half, **look)


def penalty_axis(panel: "Axes", ticks: Sequence[float]) -> None:
    """Set up the x axis for r_min."""
    panel.set_xscale("log")
    panel.set_xlim(ticks[0] / 1.3, ticks[-1] * 1.3)
    panel.set_xticks(ticks, [f"{tick:g}" for tick in ticks], minor=False)
    panel.minorticks_off()
    panel.grid(alpha=0.3)


def shared_legend(
    figure: "Figure",
    panels: Sequence["Axes"],
    columns: int = 2,
    *,
    meanings: Mapping[str, Look] | None = None,
) -> None:
    """Put one legend below all panels: an entry per label, then what ways to draw a curve mean."""
    from matplotlib.lines import Line2D

    entries = {
        label: handle
        for panel in panels
        for handle, label in zip(*panel.get_legend_handles_labels(), strict=True)
    }
    for label, look in (meanings or {}).items():
        entries[label] = Line2D([], [], **look)
    figure.legend(entries.values(), entries.keys(), loc="outside lower center", ncols=columns)


def meaning(*, filled: bool, line: str) -> Look:
    """Return how a legend shows curves with filled or hollow markers, of any colour and marker."""
    return {
        "color": "0.3",
        "marker": "o",
        "markerfacecolor": "0.3" if filled else "white",
        "markersize": 0.75 * LARGEST,
        "linestyle": line,
        "linewidth": 0.8,
    }


@column_style()
def save_figure(figure: "Figure", folder: Path, name: str) -> None:
    """Write a figure in every format; the same figure gives the same bytes.

    A PNG gets a palette, which reduces its size to a third.
    """
    with extra("plot"):
        from matplotlib import rc_context
        from PIL import Image

    with rc_context({"svg.hashsalt": name}):
        for ending, metadata in FORMATS.items():
            figure.savefig(folder / f"{name}{ending}", dpi=DPI, metadata=metadata)
    path = folder / f"{name}.png"
    drawn = Image.open(path).convert("RGB")
    drawn.quantize(PALETTE, dither=Image.Dither.NONE).save(path, optimize=True)
