"""The belief over time with the decisions marked, as in the paper's Fig. 3."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from beltsort import Belief, SortingModel
from beltsort.cell.bins import REJECT
from beltsort.errors import JournalError
from beltsort.planning.decisions import right_bins
from beltsort.sorting.entries import Decided, Scanned, Skipped, Started
from beltsort.sorting.journal import Entry
from beltsort.util.colours import COLOURS, MARKERS
from beltsort.util.extras import extra
from beltsort.util.figure_style import COLUMN, DPI, column_style, empty_figure
from beltsort.util.text import position_number

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

STEP = 0.05
"""Least width of a planner step, inches."""

PANEL = 1.25
"""Height of a panel, inches."""

TRUE, DECIDED = 1.06, 1.19
"""Heights of the rows of letters above a panel, in heights of the panel."""


@dataclass
class Standstill:
    """The beliefs from one advance of the belt to the next.

    Attributes
    ----------
    first
        The planner step at its beginning.
    beliefs
        The belief at each of its steps, of shape (H, L); the first is that after the advance.
    decided
        Name of the bin decided at its last step; None if the cup was skipped, or the run ended here.
    """

    first: int
    beliefs: list[NDArray[np.float64]]
    decided: str | None = None

    @property
    def last(self) -> int:
        """The planner step at its end."""
        return self.first + len(self.beliefs) - 1


def standstills(entries: Sequence[Entry]) -> tuple[list[Standstill], SortingModel]:
    """Return the beliefs of a journalled run, a standstill for each object, and the model.

    Raises
    ------
    JournalError
        If the journal has no start entry.
    """
    first = entries[0].content if entries else None
    if not isinstance(first, Started):
        raise JournalError("the journal has no start entry; was the run killed before it began?")
    model = SortingModel.from_json(first.model)
    found = [Standstill(0, [Belief(model).probabilities])]
    for entry in entries:
        now = found[-1]
        match entry.content:
            case Scanned(belief=rows):
                now.beliefs.append(np.asarray(rows))
            case Decided(label):
                now.decided = REJECT if label is None else model.bins[label]
                now.beliefs.append(now.beliefs[-1])
                found.append(_advanced(now, model))
            case Skipped():
                found.append(_advanced(now, model))
    return found, model


def _advanced(before: Standstill, model: SortingModel) -> Standstill:
    return Standstill(before.last, [np.vstack([before.beliefs[-1][1:], model.arrival])])


def belief_over_time(
    entries: list[Entry],
) -> tuple[NDArray[np.float64], list[tuple[int, str]], SortingModel]:
    """Return the belief after each scan and decision, the decisions, and the model of a journalled run.

    Returns
    -------
    beliefs
        Shape (n + 1, H, L); row 0 is the arrival prior. A decision's row shows the belief behind it.
    decisions
        (row, name of the bin) of each.
    model
        The model it was planned with.

    Raises
    ------
    JournalError
        If the journal has no start entry.
    """
    found, model = standstills(entries)
    beliefs = [found[0].beliefs[0], *(belief for now in found for belief in now.beliefs[1:])]
    decisions = [(now.last, now.decided) for now in found if now.decided is not None]
    return np.stack(beliefs), decisions, model


def draw_belief(entries: list[Entry], path: Path, true_classes: Sequence[str] | None = None) -> None:
    """Draw a journalled run into a file.

    Parameters
    ----------
    entries, true_classes
        As in `belief_figure`.
    path
        The picture; its ending (png, svg, pdf) is its format.
    """
    belief_figure(entries, true_classes).savefig(path, dpi=DPI)


@column_style()
def belief_figure(entries: list[Entry], true_classes: Sequence[str] | None = None) -> "Figure":
    """Draw a journalled run: a panel per belt position, a line per class, the decisions as vertical lines.

    A line ends where the belt advances: what follows is about the next object. Letters above the panels are
    the first ones of class and bin.

    Parameters
    ----------
    entries
        From `beltsort.sorting.journal.read_journal`.
    true_classes
        Class of each object, from the first one of the run on; if given, they are drawn above the panels, and
        wrong decisions are marked.
    """
    with extra("plot"):
        from matplotlib.ticker import MaxNLocator

    found, model = standstills(entries)
    if len(found) > 1 and len(found[-1].beliefs) == 1:
        found.pop()  # the run ended with a decision: nothing was learnt of the next object
    positions = len(found[0].beliefs[0])
    figure = empty_figure(max(COLUMN, STEP * found[-1].last), PANEL * positions + 0.75)
    panels = figure.subplots(positions, 1, sharex=True, squeeze=False)[:, 0]
    for j, panel in enumerate(panels):
        for i, name in enumerate(model.classes):
            look = {"color": COLOURS[i % len(COLOURS)], "marker": MARKERS[i % len(MARKERS)]}
            for n, now in enumerate(found):
                steps = range(now.first, now.last + 1)
                rows = [belief[j, i] for belief in now.beliefs]
                label = name if n == 0 else None
                panel.plot(steps, rows, label=label, markersize=2.5, linewidth=0.8, **look)
        panel.set(ylim=(-0.04, 1.04), yticks=(0.0, 0.5, 1.0), ylabel=f"belief, position {position_number(j)}")
        panel.set_xlim(-0.7, found[-1].last + 0.7)
        panel.grid(alpha=0.3, axis="y")
        for n, now in enumerate(found):
            if now.decided is not None:
                label = "decision, belt advances" if n == 0 else None
                panel.axvline(now.last, color="black", linestyle="--", linewidth=0.6, zorder=0, label=label)
        _write_classes(panel, found, j, model, true_classes)
    panels[-1].set_xlabel("planner step")
    panels[-1].xaxis.set_major_locator(MaxNLocator(integer=True))
    handles, labels = panels[0].get_legend_handles_labels()
    if true_classes is not None:
        handles.append(panels[0].scatter([], [], marker="s", color="black", s=30))
        labels.append("white on black: wrong")
    figure.legend(handles, labels, loc="outside lower center", ncols=3)
    return figure


def _write_classes(
    panel: "Axes",
    found: Sequence[Standstill],
    position: int,
    model: SortingModel,
    true_classes: Sequence[str] | None,
) -> None:
    """Write above a panel, over each standstill, what the object there is and what was decided."""
    rows = {TRUE: "true"} if true_classes is not None else {}
    if position == 0:
        rows[DECIDED] = "decided"
    for height, name in rows.items():
        panel.text(-0.01, height, name, transform=panel.transAxes, ha="right", va="center")
    for n, now in enumerate(found):
        middle = 0.5 * (now.first + now.last)
        where: dict[str, Any] = {"transform": panel.get_xaxis_transform(), "ha": "center", "va": "center"}
        true = None
        if true_classes is not None and n + position < len(true_classes):
            true = true_classes[n + position]
            panel.text(middle, TRUE, true[0].upper(), color=_colour(true, model), fontweight="bold", **where)
        if position == 0 and now.decided is not None:
            right = true is None or _is_right(now.decided, true, model)
            box = None if right else {"boxstyle": "square,pad=0.1", "color": "black"}
            colour = _colour(now.decided, model) if right else "white"
            panel.text(
                middle, DECIDED, now.decided[0].upper(), color=colour, fontweight="bold", bbox=box, **where
            )


def _colour(name: str, model: SortingModel) -> str:
    """Return the colour of a class, black for a bin of another name."""
    return COLOURS[model.classes.index(name) % len(COLOURS)] if name in model.classes else "black"


def _is_right(bin_name: str, true: str, model: SortingModel) -> bool:
    """Return whether an object of class `true` belongs in the bin; nothing belongs in the reject bin."""
    if bin_name not in model.bins:
        return False
    return bool(right_bins(model)[model.bins.index(bin_name), model.classes.index(true)])
