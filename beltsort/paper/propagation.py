"""How the belief is updated by scans and handed on along the belt, as in the paper's Fig. 2."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from beltsort import Belief, SortingModel
from beltsort.paper.style import new_figure
from beltsort.util.colours import COLOURS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

HATCHES = ("", "//", "..", "xx")
SCANS = ((2, (0, 1)), (2, (0, 1)))
"""(viewpoint, label at each position) of the scans drawn: an elongated bulb before a livarno."""


def propagated(
    model: SortingModel, scans: Sequence[tuple[int, Sequence[int]]] = SCANS
) -> list[tuple[str, NDArray[np.float64]]]:
    """Return the belief at the start, after each scan, and after the decision that the belt then moves on.

    Returns
    -------
    list of (str, array)
        A name, and probabilities of shape (H, L).

    Examples
    --------
    >>> from beltsort.models import paper
    >>> stages = propagated(paper())
    >>> bool(np.array_equal(stages[-1][1][0], stages[-2][1][1]))
    True
    """
    belief = Belief(model)
    stages = [("arrival prior", belief.probabilities)]
    for viewpoint, labels in scans:
        belief.observe(viewpoint, labels)
        said = ", ".join(model.classes[label] for label in labels)
        stages.append((f"scan from {model.viewpoints[viewpoint]}:\n{said}", belief.probabilities))
    label, _ = belief.most_likely(0)
    belief.advance()
    return [*stages, (f"decide {model.classes[label]},\nbelt moves on", belief.probabilities)]


def propagation_figure(model: SortingModel) -> "Figure":
    """Draw the belief of each position, stage by stage."""
    stages = propagated(model)
    figure, panels = new_figure(model.positions, len(stages), (2.5, 2.0))
    for column, (name, probabilities) in zip(panels.T, stages, strict=True):
        column[0].set_title(name, fontsize=9)
        for j, panel in enumerate(column):
            bars = panel.bar(model.classes, probabilities[j], edgecolor="black")
            for i, bar in enumerate(bars):
                bar.set(facecolor=COLOURS[i % len(COLOURS)], hatch=HATCHES[i % len(HATCHES)])
                panel.text(
                    i, probabilities[j, i], f"{probabilities[j, i]:.2f}", ha="center", va="bottom", fontsize=8
                )
            panel.set(ylim=(0.0, 1.15), yticks=(0.0, 0.5, 1.0))
            panel.tick_params(axis="x", rotation=30, labelsize=7)
    for j, panel in enumerate(panels[:, 0]):
        panel.set_ylabel(f"belief, position {j + 1}")
    return figure
