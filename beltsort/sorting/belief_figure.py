"""The belief over time with the decisions marked, as in the paper's Fig. 3."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from beltsort import Belief, SortingModel
from beltsort.cell.bins import REJECT
from beltsort.errors import JournalError
from beltsort.sorting.entries import Decided, Scanned, Skipped, Started
from beltsort.sorting.journal import Entry
from beltsort.util.colours import COLOURS, MARKERS
from beltsort.util.extras import extra


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
    first = entries[0].content if entries else None
    if not isinstance(first, Started):
        raise JournalError("the journal has no start entry; was the run killed before it began?")
    model = SortingModel.from_json(first.model)
    belief = Belief(model).probabilities
    beliefs, decisions = [belief], []
    for entry in entries:
        match entry.content:
            case Scanned(belief=rows):
                belief = np.asarray(rows)
                beliefs.append(belief)
            case Decided(label):
                beliefs.append(belief)
                decisions.append((len(beliefs) - 1, REJECT if label is None else model.bins[label]))
                belief = np.vstack([belief[1:], model.arrival])
            case Skipped():
                belief = np.vstack([belief[1:], model.arrival])
    return np.stack(beliefs), decisions, model


def draw_belief(entries: list[Entry], path: Path) -> None:
    """Draw a journalled run: a panel per belt position, a line per class, the decisions as vertical lines.

    Parameters
    ----------
    entries
        From `beltsort.sorting.journal.read_journal`.
    path
        The picture; its ending (png, svg, pdf) is its format.
    """
    with extra("plot"):
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
        from matplotlib.ticker import MaxNLocator

    beliefs, decisions, model = belief_over_time(entries)
    steps, positions, _ = beliefs.shape
    figure = Figure(figsize=(max(7.0, 0.2 * steps), 2.2 * positions + 0.8), layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(positions, 1, sharex=True, squeeze=False)[:, 0]
    for j, panel in enumerate(panels):
        for i, name in enumerate(model.classes):
            style = {"color": COLOURS[i % len(COLOURS)], "marker": MARKERS[i % len(MARKERS)]}
            panel.plot(range(steps), beliefs[:, j, i], label=name, markersize=4, linewidth=1.2, **style)
        panel.set(ylim=(-0.03, 1.14), yticks=(0.0, 0.25, 0.5, 0.75, 1.0), ylabel=f"belief, position {j + 1}")
        panel.grid(alpha=0.3)
        for step, _name in decisions:
            panel.axvline(step, color="black", linestyle="--", linewidth=0.8)
    for step, name in decisions:
        panels[0].annotate(
            f"$d_\\mathrm{{{name[0]}}}$",
            (step, 1.05),
            xytext=(3, 0),
            textcoords="offset points",
        )
    panels[-1].set_xlabel("planner step")
    panels[-1].xaxis.set_major_locator(MaxNLocator(integer=True))
    figure.legend(
        *panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=len(model.classes)
    )
    figure.savefig(path, dpi=120)
