"""Pictures of what the paper does not have: bounds of the optimum, and four further studies."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from beltsort.paper.beyond import BONUS, POSITIONS, STUDIES
from beltsort.paper.curves import TICKS, WORDS
from beltsort.paper.outcomes import Row, select
from beltsort.paper.policies import POLICIES
from beltsort.paper.statistics import mean
from beltsort.paper.style import (
    ERROR_BARS,
    curve,
    new_figure,
    penalty_axis,
    shared_legend,
    style,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LOSS_FLOOR = 1e-3  # what is measured smaller is drawn here: the axis is logarithmic
VARIED = "as many positions as the axis says"
SHOWN = (("steps", "steps for ten objects"), ("positives", "right decisions of ten"))


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
    figure, panels = new_figure(len(SHOWN), len(STUDIES))
    for (study, axis), column in zip(STUDIES.items(), panels.T, strict=True):
        for panel, (outcome, name) in zip(column, SHOWN, strict=True):
            _study(panel, select(rows, study=study), outcome)
            panel.set(xlabel=axis, ylabel=name)
            panel.grid(alpha=0.3)
            _settings_axis(panel, sorted({row["setting"] for row in select(rows, study=study)}), study)
        column[0].set_title(study)
    figure.suptitle(f"Beyond the paper: DESPOT, $r_\\mathrm{{min}}$ = 50, paper's tables; {ERROR_BARS}")
    shared_legend(figure, panels.ravel())
    return figure


def _settings_axis(panel: "Axes", settings: Sequence[float], study: str) -> None:
    if study == BONUS:
        panel.set_xscale("symlog", linthresh=1.0)
        panel.minorticks_off()
    panel.set_xticks(settings, [f"{setting:g}" for setting in settings])


def _study(panel: "Axes", rows: Sequence[Row], outcome: str) -> None:
    lines: dict[str, list[Row]] = {}
    for row in sorted(rows, key=lambda row: float(row["setting"])):
        name = VARIED if row["study"] == POSITIONS else WORDS[row["positions"]]
        lines.setdefault(name, []).append(row)
    for name, line in lines.items():
        number = (*WORDS.values(), VARIED).index(name)
        curve(panel, [row["setting"] for row in line], line, outcome, label=name, **style(number))
