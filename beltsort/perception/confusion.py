"""Confusion matrices, as counts, as text and as a picture."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from beltsort.perception.classifier import Match
from beltsort.util.extras import extra
from beltsort.util.html import box, table
from beltsort.util.text import text_table

COLOURS = "cividis"  # readable for colour-blind readers too; in grey it runs from dark to light
READABLE_ON_DARK, READABLE_ON_LIGHT = "white", "black"


@dataclass(frozen=True, eq=False)
class Confusion:
    """Counts of labels by true class.

    Attributes
    ----------
    classes
        Names of the L classes.
    counts
        Row: true class, column: label, the last one for no label; shape (L, L + 1).

    Examples
    --------
    >>> answers = [Match(label, np.ones(2)) for label in (0, 1, 1, None)]
    >>> print(confusion([0, 0, 1, 1], answers, ["bulb", "cup"]))
      true  bulb  cup  none   right
      bulb     1    1     0  50.0 %
      cup      0    1     1  50.0 %
    """

    classes: tuple[str, ...]
    counts: NDArray[np.int64]

    @property
    def right(self) -> int:
        """Number of right labels."""
        return int(np.trace(self.counts))

    @property
    def total(self) -> int:
        """Number of answers."""
        return int(self.counts.sum())

    @property
    def recall(self) -> NDArray[np.float64]:
        """Share of each class that is labelled right, shape (L,); NaN for a class without an answer."""
        with np.errstate(invalid="ignore"):
            shares: NDArray[np.float64] = np.diagonal(self.counts) / self.counts.sum(axis=1)
        return shares

    def __str__(self) -> str:
        """Return the counts as a table."""
        return text_table([self._header(), *self._rows()])

    def __repr__(self) -> str:
        """Return the number of right labels, and the counts as a table."""
        return f"{self._title()}\n{self}"

    def _repr_html_(self) -> str:
        """Return HTML for notebooks."""
        shares = self.counts / np.maximum(self.counts.sum(axis=1, keepdims=True), 1)
        shades = [[*row, 0.0] for row in shares.tolist()]
        return box(self._title(), table(self._rows(), header=self._header(), shades=shades))

    def _title(self) -> str:
        return f"Confusion: {self.right} of {self.total} right"

    def _header(self) -> list[str]:
        return ["true", *self.classes, "none", "right"]

    def _rows(self) -> list[list[str]]:
        shares = [f"{100.0 * share:.1f} %" for share in self.recall]
        return [
            [name, *map(str, row), share]
            for name, row, share in zip(self.classes, self.counts, shares, strict=True)
        ]


def confusion(true_labels: Iterable[int], matches: Sequence[Match], classes: Sequence[str]) -> Confusion:
    """Count the labels of each true class.

    Parameters
    ----------
    true_labels
        Class index of each answered candidate.
    matches
        The answers.
    classes
        Names of the classes.
    """
    counts = np.zeros((len(classes), len(classes) + 1), np.int64)
    for true, match in zip(true_labels, matches, strict=True):
        counts[true, len(classes) if match.label is None else match.label] += 1
    return Confusion(tuple(classes), counts)


def draw_confusion(confusion: Confusion, path: Path) -> None:
    """Draw the share of each true class (rows) that got each label (columns), with the counts.

    Parameters
    ----------
    confusion
        The counts.
    path
        The picture; its ending (png, svg, pdf) is its format.
    """
    with extra("plot"):
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
