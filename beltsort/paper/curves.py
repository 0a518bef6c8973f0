"""The paper's Fig. 4 to 7, outcomes against the penalty of a wrong decision, and figures beyond the paper."""

from collections.abc import Sequence
from itertools import product
from typing import TYPE_CHECKING

from beltsort.paper import printed
from beltsort.paper.beyond import BONUS, POSITIONS, STUDIES
from beltsort.paper.instances import OBJECTS, TWO
from beltsort.paper.labels import LEVEL as LABELS
from beltsort.paper.labels import STUDY
from beltsort.paper.outcomes import Row, select
from beltsort.paper.policies import (
    INFORMATION_GAIN,
    OPTIMUM,
    PLANNERS,
    POLICIES,
    PUBLISHED,
    RECOMMENDED,
    THRESHOLD,
)
from beltsort.paper.scans import LEVEL as SCANS
from beltsort.paper.statistics import mean
from beltsort.paper.style import (
    ERROR_BARS,
    PRINTED,
    curve,
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
SHOWN = (RECOMMENDED, OPTIMUM, THRESHOLD, INFORMATION_GAIN, PUBLISHED)
TICKS = (5.0, 20.0, 50.0, 200.0, 500.0)
DECISIONS = (("positives", "right", True), ("negatives", "wrong", False))
OF_TEN = "objects of ten"
WORDS = {1: "one position", 2: "two positions"}
LOSS_FLOOR = 1e-3  # smaller losses are drawn here: the axis is logarithmic
VARIED = "as many positions as the axis says"
BEYOND = (("steps", "steps for ten objects"), ("positives", "right decisions of ten"))


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
                aside = number - 0.5 * (len(SHOWN) - 1)
                penalty_curve(panel, found, outcome, aside, label=f"{policy}, {name}", **look)
        if is_paper:
            panel.plot(*_columns(printed.POSITIVES), label="paper's robot, right", **PRINTED)
        panel.set(ylim=(-0.5, 10.5), ylabel=OF_TEN)
    figure.suptitle(f"Right and wrong decisions, {WORDS[positions]}, discount {discount:g}; {ERROR_BARS}")
    shared_legend(figure, panels.ravel(), 5)
    return figure


def steps_figure(rows: Sequence[Row], discount: float) -> "Figure":
    """Draw total steps for ten objects against r_min, one position against two: Fig. 6."""
    lines = list(product(enumerate(SHOWN), WORDS))
    figure, panels = new_figure(len(OBJECTS), len(SOURCES))
    for panel, shown, is_paper in _panels(panels, rows, discount):
        for place, ((number, policy), positions) in enumerate(lines):
            if found := select(shown, policy=policy, positions=positions):
                alone = positions == 1
                look = style(number, filled=alone) | {"linestyle": "-" if alone else "--"}
                aside = place - 0.5 * (len(lines) - 1)
                penalty_curve(panel, found, "steps", aside, label=f"{policy}, {WORDS[positions]}", **look)
        if is_paper:
            label = "paper's robot, by $r_\\mathrm{min}$"
            panel.plot(*_columns(printed.STEPS), label=label, **PRINTED)
            for positions, marker in ((1, "P"), (2, "X")):
                look = PRINTED | {"marker": marker, "markersize": 8}
                steps = printed.STEPS_BY_POSITIONS[positions]
                panel.plot([printed.R_MIN], [steps], label=f"paper's robot, {WORDS[positions]}", **look)
        panel.set(ylabel="steps for ten objects", ylim=(0.0, None))
    figure.suptitle(f"Steps to sort ten objects, discount {discount:g}; {ERROR_BARS}")
    shared_legend(figure, panels.ravel())
    return figure


def one_against_two_figure(rows: Sequence[Row], discount: float) -> "Figure":
    """Draw the planners' positives and negatives, one position against two: Fig. 7."""
    lines = list(product(PLANNERS, WORDS))
    figure, panels = new_figure(len(OBJECTS), len(SOURCES))
    for panel, shown, _ in _panels(panels, rows, discount):
        for number, (planner, positions) in enumerate(lines):
            found = select(shown, policy=planner, positions=positions)
            for outcome, name, filled in DECISIONS if found else ():
                look = style(number, filled=filled)
                aside = number - 0.5 * (len(lines) - 1)
                label = f"{planner}, {name}, {WORDS[positions]}"
                penalty_curve(panel, found, outcome, aside, label=label, **look)
        panel.set(ylim=(-0.5, 10.5), ylabel=OF_TEN)
    figure.suptitle(f"The planners' right and wrong decisions, discount {discount:g}; {ERROR_BARS}")
    shared_legend(figure, panels.ravel(), 3)
    return figure


def bounds_figure(optimum: Sequence[Row]) -> "Figure":
    """Draw the certified bounds of the optimum, and what each policy's actions lose against it.

    Parameters
    ----------
    optimum
        From `beltsort.paper.optimum.bound_optimum`.
    """
    figure, panels = new_figure(2, len(WORDS), (4.6, 2.9))
    for (value, loss), positions in zip(panels.T, WORDS, strict=True):
        rows = select(optimum, positions=positions)
        x = [row["r_min"] for row in rows]
        lower, upper = ([row[end] for row in rows] for end in ("lower", "upper"))
        value.fill_between(x, lower, upper, color="0.75", label="certified bounds of the optimum")
        value.plot(x, lower, color="black", linewidth=1.0, marker="_", label="lower bound: a policy's value")
        value.set(ylabel="value (discounted reward)", title=WORDS[positions])
        for number, policy in enumerate(POLICIES):
            losses = [mean(row["losses"][policy]) for row in rows]
            means = [max(estimate.value, LOSS_FLOOR) for estimate in losses]
            errors = [estimate.interval[1] - estimate.value for estimate in losses]
            loss.errorbar(x, means, yerr=errors, label=policy, **style(number))
        loss.set(yscale="log", ylabel=f"loss per batch ({LOSS_FLOOR:g}: or less)")
        penalty_axis(value, TICKS)
        penalty_axis(loss, TICKS)
    figure.suptitle("Bounds of the best possible value, and loss against the upper bound (paper's tables)")
    shared_legend(figure, panels.ravel(), 3)
    return figure


def beyond_figure(rows: Sequence[Row]) -> "Figure":
    """Draw steps and right decisions for each further study, a column per study."""
    figure, panels = new_figure(len(BEYOND), len(STUDIES))
    names = (*WORDS.values(), VARIED)
    for (study, axis), column in zip(STUDIES.items(), panels.T, strict=True):
        lines: dict[tuple[str, str], list[Row]] = {}
        for row in sorted(select(rows, study=study), key=lambda row: float(row["setting"])):
            name = VARIED if study == POSITIONS else WORDS[row["positions"]]
            lines.setdefault((row["policy"], name), []).append(row)
        settings = sorted({row["setting"] for line in lines.values() for row in line})
        for panel, (outcome, title) in zip(column, BEYOND, strict=True):
            for (planner, name), line in lines.items():
                x = [row["setting"] for row in line]
                recommended = planner == RECOMMENDED
                look = style(names.index(name), filled=recommended) | {
                    "linestyle": "-" if recommended else "--"
                }
                curve(panel, x, line, outcome, label=f"{planner}, {name}", **look)
            panel.set(xlabel=axis, ylabel=title)
            panel.grid(alpha=0.3)
            if study == BONUS:
                panel.set_xscale("symlog", linthresh=1.0)
                panel.minorticks_off()
            panel.set_xticks(settings, [f"{setting:g}" for setting in settings])
        column[0].set_title(study)
    figure.suptitle(f"Beyond the paper: $r_\\mathrm{{min}}$ = 50, paper's tables; {ERROR_BARS}")
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


def _columns(numbers: dict[float, float]) -> tuple[list[float], list[float]]:
    return list(numbers), list(numbers.values())
