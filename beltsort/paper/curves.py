"""The paper's Fig. 4 to 7, outcomes against the penalty of a wrong decision, and figures beyond the paper.

Rows are those of plain tables, see `beltsort.paper.outcomes.plain_table`. Panels that are compared share
their scales, and every point stands at its own value: markers differ in size, so that all are seen.
"""

from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from beltsort.paper import printed
from beltsort.paper.beyond import ARRIVAL, BONUS, POSITIONS, SHARPNESS, STUDIES
from beltsort.paper.instances import TWO
from beltsort.paper.optimum import loss_of
from beltsort.paper.outcomes import Row, estimate_in, select
from beltsort.paper.outline import THE_PAPER, Outline, positions_in_words
from beltsort.paper.policies import (
    RECOMMENDED,
)
from beltsort.paper.style import (
    PRINTED,
    ROW,
    Look,
    curve,
    meaning,
    new_figure,
    penalty_axis,
    shared_legend,
    style,
)
from beltsort.planning.throughput import PURITY
from beltsort.util.figure_style import column_style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

DECISIONS = (("positives", True), ("negatives", False))
RIGHT_OR_WRONG = {
    "filled: right": meaning(filled=True, line="none"),
    "hollow: wrong": meaning(filled=False, line="none"),
}
OF_TEN = "objects of ten"
PENALTY = "penalty $r_\\mathrm{min}$"
LINES = ("-", "--", "-.", ":")
"""Lines by the number of positions, the fewest first."""

LOSS_FLOOR = 1e-3  # smaller losses are drawn here: the axis is logarithmic
ROW_ALONE = 2.0  # inches; height of a panel without others below it
MOST_STEPS = 82.0  # above all curves, and the paper's 75
VARIED = "as many positions as the axis says"
BEYOND = (("steps", "steps for ten"), ("positives", "right of ten"))
MOVING = (("least_purity", "purity of the least pure bin"), ("right", "right, share of all objects"))


@column_style()
def accuracy_figure(
    rows: Sequence[Row], positions: int, discount: float, outline: Outline = THE_PAPER
) -> "Figure":
    """Draw positives and negatives of ten against r_min, for every policy: Fig. 4 (one position) and 5 (two).

    Parameters
    ----------
    rows
        Of tables and scans.
    positions
        Belt positions seen at once.
    discount
        Whose rows are shown.
    outline
        What was varied.
    """
    figure, panels = _grid(outline)
    for panel, shown, is_papers in _panels(panels, rows, discount, outline):
        for number, policy in enumerate(outline.shown):
            found = select(shown, policy=policy, positions=positions)
            for outcome, filled in DECISIONS if found else ():
                look = style(number, filled=filled)
                curve(panel, _penalties(found), found, outcome, label=policy if filled else None, **look)
        if is_papers:
            panel.plot(*_columns(printed.POSITIVES), label="paper's robot, right", **PRINTED)
        panel.set(ylim=(-0.5, 10.5), yticks=(0.0, 5.0, 10.0))
    _finish(figure, panels, OF_TEN, RIGHT_OR_WRONG)
    return figure


@column_style()
def steps_figure(rows: Sequence[Row], discount: float, outline: Outline = THE_PAPER) -> "Figure":
    """Draw total steps for ten objects against r_min, for every number of positions: Fig. 6."""
    figure, panels = _grid(outline)
    for panel, shown, is_papers in _panels(panels, rows, discount, outline):
        for (number, policy), (place, positions) in product(
            enumerate(outline.shown), enumerate(outline.positions)
        ):
            if found := select(shown, policy=policy, positions=positions):
                look = style(number, filled=place == 0) | {"linestyle": LINES[place % len(LINES)]}
                curve(panel, _penalties(found), found, "steps", label=None if place else policy, **look)
        if is_papers:
            label = "paper's robot, by $r_\\mathrm{min}$"
            panel.plot(*_columns(printed.STEPS), label=label, **PRINTED)
            for positions, marker in ((1, "P"), (2, "X")):
                look = PRINTED | {"marker": marker, "markersize": 5}
                steps = printed.STEPS_BY_POSITIONS[positions]
                label = f"paper's robot, {positions_in_words(positions)}"
                panel.plot([printed.R_MIN], [steps], label=label, **look)
        panel.set_ylim(0.0, MOST_STEPS if outline.of_the_paper else None)
    meanings = {
        f"{'hollow' if place else 'filled'}: {positions_in_words(positions)}": meaning(
            filled=place == 0, line=LINES[place % len(LINES)]
        )
        for place, positions in enumerate(outline.positions)
    }
    _finish(figure, panels, "steps for ten objects", meanings)
    return figure


@column_style()
def one_against_two_figure(rows: Sequence[Row], discount: float, outline: Outline = THE_PAPER) -> "Figure":
    """Draw positives and negatives, the fewest positions against the most: Fig. 7.

    Of the planners; if there are policies of one's own, of the recommended planner and of these, in which
    case a policy has the same colour and marker for all positions.
    """
    figure, panels = _grid(outline)
    own = outline.own_policies
    judged = (RECOMMENDED, *own) if own else outline.judged
    compared = (outline.positions[0], outline.positions[-1])
    for panel, shown, _ in _panels(panels, rows, discount, outline):
        for number, (policy, positions) in enumerate(product(judged, compared)):
            found = select(shown, policy=policy, positions=positions)
            for outcome, filled in DECISIONS if found else ():
                look = style(number, filled=filled)
                if own:
                    look = style(outline.shown.index(policy), filled=filled)
                    look["linestyle"] = LINES[compared.index(positions)]
                label = f"{policy}, {positions_in_words(positions)}" if filled else None
                curve(panel, _penalties(found), found, outcome, label=label, **look)
        panel.set(ylim=(-0.5, 10.5), yticks=(0.0, 5.0, 10.0))
    _finish(figure, panels, OF_TEN, RIGHT_OR_WRONG, columns=1)
    return figure


@column_style()
def bounds_figure(optimum: Sequence[Row], outline: Outline = THE_PAPER) -> "Figure":
    """Draw the certified bounds of the optimum, and what each policy's actions lose against it.

    Parameters
    ----------
    optimum
        From `beltsort.paper.optimum.losses_table`.
    outline
        What was varied.
    """
    solved = sorted({row["positions"] for row in optimum})
    figure, panels = new_figure(2, len(solved), 1.4, sharex=True, sharey="row")
    for (value, loss), positions in zip(panels.T, solved, strict=True):
        rows = select(optimum, positions=positions)
        x = _penalties(rows)
        lower, upper = ([row[end] for row in rows] for end in ("lower", "upper"))
        value.fill_between(x, lower, upper, color="0.75", label="certified bounds of the optimum")
        value.plot(x, lower, color="black", linewidth=0.8, marker="_", label="lower: a policy's value")
        value.set_title(positions_in_words(positions))
        for number, policy in enumerate(outline.policies):
            if loss_of(policy) not in rows[0]:
                continue
            losses = [estimate_in(row, loss_of(policy)) for row in rows]
            # A logarithmic axis has no place for zero: values and ends of intervals are drawn at the floor.
            ends = [(each.interval[0], each.value, each.interval[1]) for each in losses]
            low, means, high = np.maximum(ends, LOSS_FLOOR).T
            loss.errorbar(x, means, yerr=(means - low, high - means), label=policy, **style(number))
        loss.set_yscale("log")
        loss.set_ylim(LOSS_FLOOR / 1.5, None)
        penalty_axis(value, outline.ticks)
        penalty_axis(loss, outline.ticks)
    value, loss = panels[:, 0]
    value.set_ylabel("value (discounted reward)")
    loss.set_ylabel("loss per batch")
    ticks = [tick for tick in (1e-3, 1e-2, 1e-1, 1.0, 10.0) if LOSS_FLOOR <= tick <= loss.get_ylim()[1]]
    loss.set_yticks(ticks, [f"≤ {ticks[0]:g}", *(f"{tick:g}" for tick in ticks[1:])], minor=False)
    for loss in panels[1]:
        loss.set_xlabel(PENALTY)
    shared_legend(figure, panels.ravel())
    return figure


@column_style()
def beyond_figure(rows: Sequence[Row]) -> "Figure":
    """Draw steps and right decisions for each further study, a row per study."""
    figure, panels = new_figure(len(STUDIES), len(BEYOND), 1.05)
    names = (*map(positions_in_words, THE_PAPER.positions), VARIED)
    for (study, axis), line in zip(STUDIES.items(), panels, strict=True):
        curves: dict[tuple[str, str], list[Row]] = {}
        for row in sorted(select(rows, study=study), key=lambda row: float(row["setting"])):
            name = VARIED if study == POSITIONS else positions_in_words(row["positions"])
            curves.setdefault((row["policy"], name), []).append(row)
        settings = sorted({row["setting"] for found in curves.values() for row in found})
        for panel, (outcome, title) in zip(line, BEYOND, strict=True):
            for (planner, name), found in curves.items():
                x = [row["setting"] for row in found]
                recommended = planner == RECOMMENDED
                look = style(names.index(name), filled=recommended) | {
                    "linestyle": "-" if recommended else "--"
                }
                curve(panel, x, found, outcome, label=f"{planner}, {name}", **look)
            panel.set_ylabel(title)
            panel.grid(alpha=0.3)
            if study == BONUS:
                panel.set_xscale("symlog", linthresh=1.0)
                panel.minorticks_off()
            elif study == SHARPNESS:
                panel.set_xscale("log")
                panel.minorticks_off()
            panel.set_xticks(settings, [f"{setting:g}" for setting in settings])
            if study == ARRIVAL:  # the last two are near each other
                for tick, side in zip(panel.get_xticklabels()[-2:], ("right", "left"), strict=True):
                    tick.set_horizontalalignment(side)
        line[0].set_title(axis, loc="left")
    for column, bottom in zip(panels.T, (0.0, None), strict=True):
        for panel in column[1:]:
            panel.sharey(column[0])
        column[0].autoscale(axis="y")
        column[0].set_ylim(bottom, None)
    shared_legend(figure, panels.ravel(), 1)
    return figure


@column_style()
def moving_figure(rows: Sequence[Row]) -> "Figure":
    """Draw least purity and right objects against the objects decided per minute, a curve per policy.

    Parameters
    ----------
    rows
        From `beltsort.paper.moving.moving_table`.
    """
    figure, panels = new_figure(len(MOVING), 1, 1.5, sharex=True)
    for panel, (outcome, title) in zip(panels[:, 0], MOVING, strict=True):
        for number, policy in enumerate(dict.fromkeys(row["policy"] for row in rows)):
            found = [row for row in rows if row["policy"] == policy]
            rates = [row["objects_per_minute"] for row in found]
            curve(panel, rates, found, outcome, label=policy, **style(number))
        panel.set_ylabel(title)
        panel.grid(alpha=0.3)
    panels[0, 0].axhline(PURITY, color="0.3", linestyle=":", linewidth=0.8)
    panels[-1, 0].set_xlabel("objects decided per minute")
    shared_legend(figure, panels.ravel())
    return figure


def _grid(outline: Outline) -> "tuple[Figure, Any]":
    """Return a figure with a panel for each source and set of objects; a row alone is higher."""
    rows, columns = len(outline.sources), len(outline.objects)
    return new_figure(rows, columns, ROW if rows > 1 else ROW_ALONE, sharex=True, sharey=True)


def _panels(
    panels: "Sequence[Sequence[Axes]]", rows: Sequence[Row], discount: float, outline: Outline
) -> "Iterator[tuple[Axes, list[Row], bool]]":
    """Yield each panel, the rows it shows, and whether the paper's own numbers belong there."""
    for source, line in zip(outline.sources, panels, strict=True):
        line[0].set_title(source.title, loc="left")
        for objects, panel in zip(outline.objects, line, strict=True):
            wanted = source.condition | {"discount": discount, "objects": objects.name}
            shown = select(rows, study=outline.name, **wanted)
            penalty_axis(panel, outline.ticks)
            panel.text(0.97, 0.2, objects.name, transform=panel.transAxes, ha="right", va="center")
            yield panel, shown, outline.of_the_paper and objects.name == TWO.name


def _finish(
    figure: "Figure", panels: Any, outcome: str, meanings: Mapping[str, Look], *, columns: int = 2
) -> None:
    """Name the axes of all panels, shape (sources, objects), and add the legend."""
    for line in panels:
        line[0].set_ylabel(outcome)
    for panel in panels[-1]:
        panel.set_xlabel(PENALTY)
    shared_legend(figure, panels.ravel(), columns, meanings=meanings)


def _penalties(rows: Sequence[Row]) -> list[float]:
    return [row["r_min"] for row in rows]


def _columns(numbers: dict[float, float]) -> tuple[list[float], list[float]]:
    return list(numbers), list(numbers.values())
