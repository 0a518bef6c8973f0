"""Which class is taken for which, as a picture."""

from pathlib import Path

import numpy as np

from beltsort.perception.confusion import Confusion

COLOURS = "cividis"  # told apart by colour-blind readers too; in grey it runs from dark to light
READABLE_ON_DARK, READABLE_ON_LIGHT = "white", "black"


def draw_confusion(confusion: Confusion, path: Path) -> None:
    """Draw the share of each true class (rows) that got each label (columns), with the counts.

    Parameters
    ----------
    confusion
        What was counted.
    path
        The picture; its ending (png, svg, pdf) is its format.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    counts = confusion.counts
    shares = counts / np.maximum(counts.sum(axis=1, keepdims=True), 1)
    rows, columns = counts.shape
    figure = Figure(figsize=(2.5 + 0.8 * columns, 1.8 + 0.6 * rows), layout="constrained")
    FigureCanvasAgg(figure)
    panel = figure.subplots()
    picture = panel.imshow(shares, cmap=COLOURS, vmin=0.0, vmax=1.0, aspect="auto")
    for (row, column), share in np.ndenumerate(shares):
        colour = READABLE_ON_LIGHT if share > 0.5 else READABLE_ON_DARK
        panel.text(column, row, str(counts[row, column]), color=colour, ha="center", va="center")
    panel.set(ylabel="true class", xlabel=f"label ({confusion.right} of {confusion.total} right)")
    labels = [*confusion.classes, "none"]
    panel.set_xticks(range(columns), labels, rotation=45.0, ha="right", parse_math=False)
    panel.set_yticks(range(rows), confusion.classes, parse_math=False)
    figure.colorbar(picture, label="share of the true class")
    figure.savefig(path, dpi=120)
