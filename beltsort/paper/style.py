"""The style of the report's figures: curves differ for colour-blind readers and in grey, too."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from beltsort.paper.outcomes import Row
from beltsort.paper.statistics import CONFIDENCE, mean
from beltsort.util.colours import COLOURS, MARKERS
from beltsort.util.extras import extra

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LINES = ("-", "--", "-.", ":")
FORMATS = (".png", ".svg")
DPI = 150
PALETTE = 128  # colours of a PNG
PANEL = (3.6, 2.9)  # inches
ERROR_BARS = f"error bars: {100 * CONFIDENCE:.0f} % confidence intervals of the mean"
ASIDE = 1.04
"""Factor of one step of shift on the logarithmic axis of r_min."""
PRINTED: dict[str, Any] = {
    "color": "black",
    "marker": "*",
    "linestyle": "none",
    "markersize": 11,
    "zorder": 5,
}
"""Style of the paper's own numbers."""


def style(number: int, *, filled: bool = True) -> dict[str, Any]:
    """Return colour, marker and line of the n-th curve of a figure."""
    colour = COLOURS[number % len(COLOURS)]
    return {
        "color": colour,
        "marker": MARKERS[number % len(MARKERS)],
        "linestyle": LINES[number % len(LINES)],
        "markerfacecolor": colour if filled else "white",
        "markersize": 5,
        "linewidth": 1.3,
        "capsize": 2.5,
    }


def new_figure(rows: int, columns: int, panel: tuple[float, float] = PANEL) -> "tuple[Figure, Any]":
    """Return a figure and its panels, shape (rows, columns)."""
    with extra("plot"):
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

    figure = Figure(figsize=(columns * panel[0], rows * panel[1] + 0.6), layout="constrained")
    FigureCanvasAgg(figure)
    return figure, figure.subplots(rows, columns, squeeze=False)


def penalty_curve(panel: "Axes", rows: Sequence[Row], outcome: str, aside: float, **look: Any) -> None:
    """Draw an outcome against r_min, shifted by `aside` steps, so that no curve hides another."""
    curve(panel, [row["r_min"] * ASIDE**aside for row in rows], rows, outcome, **look)


def curve(panel: "Axes", x: Sequence[float], rows: Sequence[Row], outcome: str, **look: Any) -> None:
    """Draw means with their confidence intervals, a point per row."""
    points = [mean(row[outcome]) for row in rows]
    half = [estimate.interval[1] - estimate.value for estimate in points]
    panel.errorbar(x, [estimate.value for estimate in points], yerr=half, **look)


def penalty_axis(panel: "Axes", ticks: Sequence[float]) -> None:
    """Set up the x axis for r_min."""
    panel.set_xscale("log")
    panel.set_xlim(ticks[0] / 1.3, ticks[-1] * 1.3)
    panel.set_xticks(ticks, [f"{tick:g}" for tick in ticks], minor=False)
    panel.minorticks_off()
    panel.set_xlabel("$r_\\mathrm{min}$, penalty of a wrong decision")
    panel.grid(alpha=0.3)


def shared_legend(figure: "Figure", panels: Sequence["Axes"], columns: int = 4) -> None:
    """Put one legend below all panels, with one entry per label."""
    entries = {
        label: handle
        for panel in panels
        for handle, label in zip(*panel.get_legend_handles_labels(), strict=True)
    }
    figure.legend(entries.values(), entries.keys(), loc="outside lower center", ncols=columns, fontsize=8)


def save_figure(figure: "Figure", folder: Path, name: str) -> None:
    """Write a figure in every format; the same figure gives the same bytes."""
    with extra("plot"):
        from matplotlib import rc_context

    def draw(path: Path) -> None:
        figure.savefig(path, dpi=DPI, metadata={"Date": None} if path.suffix == ".svg" else {})

    with rc_context({"svg.hashsalt": name}):
        save_drawn(draw, folder, name)


def save_drawn(draw: Callable[[Path], None], folder: Path, name: str) -> None:
    """Call `draw` for every format; a PNG gets a palette, which reduces its size to a third."""
    with extra("plot"):
        from PIL import Image

    for path in (folder / f"{name}{ending}" for ending in FORMATS):
        draw(path)
        if path.suffix == ".png":
            drawn = Image.open(path).convert("RGB")
            drawn.quantize(PALETTE, dither=Image.Dither.NONE).save(path, optimize=True)
