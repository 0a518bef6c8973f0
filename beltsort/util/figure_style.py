"""The style of printed figures: a column of a two-column paper wide, with letters of at least 7 points."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from beltsort.util.extras import extra

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COLUMN = 3.4
"""Width of a column, inches."""

PAGE = 7.0
"""Width of both columns with the gap between them, inches."""

DPI = 240
"""Of a PNG: a column is then 816 pixels wide."""

LETTERS = 7.0
"""Size of the smallest letters, points."""

SETTINGS: Any = {
    "font.size": LETTERS,
    "axes.titlesize": LETTERS,
    "axes.labelsize": LETTERS,
    "xtick.labelsize": LETTERS,
    "ytick.labelsize": LETTERS,
    "legend.fontsize": LETTERS,
    "figure.titlesize": LETTERS,
    "axes.linewidth": 0.6,
    "axes.titlepad": 3.0,
    "axes.labelpad": 2.0,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "xtick.major.pad": 2.0,
    "ytick.major.pad": 2.0,
    "grid.linewidth": 0.4,
    "patch.linewidth": 0.6,
    "hatch.linewidth": 0.5,
    "legend.borderpad": 0.3,
    "legend.labelspacing": 0.25,
    "legend.handlelength": 2.2,
    "legend.handletextpad": 0.5,
    "legend.columnspacing": 1.0,
    "figure.constrained_layout.w_pad": 0.02,
    "figure.constrained_layout.h_pad": 0.02,
    "pdf.fonttype": 42,  # letters as letters, which can be searched and edited
}
"""matplotlib's settings; `Any`, since only newer versions of it have a type for their names."""


@contextmanager
def column_style() -> Iterator[None]:
    """Use the style for every figure that is made and drawn inside; also a decorator of functions."""
    with extra("plot"):
        from matplotlib import rc_context

    with rc_context(SETTINGS):
        yield


def empty_figure(width: float, height: float) -> "Figure":
    """Return a figure without panels; width and height in inches."""
    with extra("plot"):
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure
