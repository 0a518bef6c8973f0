"""Positives, negatives and steps against the penalty of a wrong decision: the paper's Fig. 4 to 7."""

from collections.abc import Sequence
from itertools import product
from typing import TYPE_CHECKING

from beltsort.paper import printed
from beltsort.paper.instances import OBJECTS, TWO
from beltsort.paper.labels import LEVEL as LABELS
from beltsort.paper.labels import STUDY
from beltsort.paper.outcomes import Row, select
from beltsort.paper.policies import DESPOT, INFORMATION_GAIN, OPTIMUM, THRESHOLD
from beltsort.paper.scans import LEVEL as SCANS
from beltsort.paper.style import (
    ERROR_BARS,
    PRINTED,
    new_figure,
    penalty_axis,
    penalty_curve,
    shared_legend,
    style,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SOURCES = (
    ("labels from the paper's tables", {"level": LABELS, "instance": "paper"}),
    ("labels from the cell's tables", {"level": LABELS, "instance": "cell"}),
    ("depth scans of the cell", {"level": SCANS, "instance": "cell"}),
)
SHOWN = (DESPOT, OPTIMUM, THRESHOLD, INFORMATION_GAIN)
TICKS = (5.0, 20.0, 50.0, 200.0, 500.0)
DECISIONS = (("positives", "right", True), ("negatives", "wrong", False))
OF_TEN = "objects of ten"
WORDS = {1: "one position", 2: "two positions"}


def accuracy_figure(rows: Sequence[Row], positions: int, discount: float) -> "Figure":
    """Draw positives and negatives of ten against r_min, for every policy: Fig. 4 (one position) and 5 (two).

    Parameters
    ----------
    rows
        Of tables and scans; see `beltsort.paper.outcomes`.
    positions
        Belt positions seen at once.
    discount
        Whose rows are shown.
    """
    figure, panels = new_figure(len(OBJECTS), len(SOURCES))
    for panel, shown, is_paper in _panels(panels, rows, discount):
        for number, policy in enumerate(SHOWN):
            found = select(shown, policy=policy, positions=positions)
            for outcome, name, filled in DECISIONS if found else ():
                look = style(number, filled=filled)
                penalty_curve(panel, found, outcome, number - 1.5, label=f"{policy}, {name}", **look)
        if is_paper:
            panel.plot(*_points(printed.POSITIVES), label="paper's robot, right", **PRINTED)
        panel.set(ylim=(-0.5, 10.5), ylabel=OF_TEN)
    figure.suptitle(f"Right and wrong decisions, {WORDS[positions]}, discount {discount:g}; {ERROR_BARS}")
    shared_legend(figure, panels.ravel(), 5)
    return figure


def steps_figure(rows: Sequence[Row], discount: float) -> "Figure":
    """Draw total steps for ten objects against r_min, one position against two: Fig. 6."""
    figure, panels = new_figure(len(OBJECTS), len(SOURCES))
    for panel, shown, is_paper in _panels(panels, rows, discount):
        _steps(panel, shown)
        if is_paper:
            _printed_steps(panel)
        panel.set(ylabel="steps for ten objects", ylim=(0.0, None))
    figure.suptitle(f"Steps to sort ten objects, discount {discount:g}; {ERROR_BARS}")
    shared_legend(figure, panels.ravel())
    return figure


def one_against_two_figure(rows: Sequence[Row], discount: float) -> "Figure":
    """Draw DESPOT's positives and negatives, one position against two: Fig. 7."""
    figure, panels = new_figure(len(OBJECTS), len(SOURCES))
    for panel, shown, _ in _panels(panels, rows, discount):
        for number, positions in enumerate(WORDS):
            found = select(shown, policy=DESPOT, positions=positions)
            for outcome, name, filled in DECISIONS:
                look = style(number, filled=filled)
                penalty_curve(
                    panel, found, outcome, number - 0.5, label=f"{name}, {WORDS[positions]}", **look
                )
        panel.set(ylim=(-0.5, 10.5), ylabel=OF_TEN)
    figure.suptitle(f"DESPOT's right and wrong decisions, discount {discount:g}; {ERROR_BARS}")
    shared_legend(figure, panels.ravel())
    return figure


def _panels(
    panels: "Sequence[Sequence[Axes]]", rows: Sequence[Row], discount: float
) -> "list[tuple[Axes, list[Row], bool]]":
    """Return each panel, the rows it shows, and whether the paper's own numbers belong there."""
    found = []
    for objects, line in zip(OBJECTS, panels, strict=True):
        for (title, source), panel in zip(SOURCES, line, strict=True):
            shown = select(rows, study=STUDY, discount=discount, objects=objects.name, **source)
            penalty_axis(panel, TICKS)
            panel.set_title(f"{title}\n{objects.name}", fontsize=9)
            found.append((panel, shown, objects is TWO))
    return found


def _steps(panel: "Axes", shown: Sequence[Row]) -> None:
    pairs = list(product(enumerate(SHOWN), WORDS))
    for place, ((number, policy), positions) in enumerate(pairs):
        found = select(shown, policy=policy, positions=positions)
        if found:
            alone = positions == 1
            look = style(number, filled=alone) | {"linestyle": "-" if alone else "--"}
            aside = place - 0.5 * (len(pairs) - 1)
            penalty_curve(panel, found, "steps", aside, label=f"{policy}, {WORDS[positions]}", **look)


def _printed_steps(panel: "Axes") -> None:
    panel.plot(*_points(printed.STEPS), label="paper's robot, by $r_\\mathrm{min}$", **PRINTED)
    for positions, marker in ((1, "P"), (2, "X")):
        look = PRINTED | {"marker": marker, "markersize": 8}
        steps = printed.STEPS_BY_POSITIONS[positions]
        panel.plot([printed.R_MIN], [steps], label=f"paper's robot, {WORDS[positions]}", **look)


def _points(numbers: dict[float, float]) -> tuple[list[float], list[float]]:
    return list(numbers), list(numbers.values())
