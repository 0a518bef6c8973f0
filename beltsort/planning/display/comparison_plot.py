"""Paired differences of policies, drawn with matplotlib."""

from typing import TYPE_CHECKING

from beltsort.planning.difference import CONFIDENCE, PairedStatistics
from beltsort.util.colours import COLOURS
from beltsort.util.extras import extra

if TYPE_CHECKING:
    from matplotlib.axes import Axes

INCHES = 0.38  # of one policy
EDGES = 1.25  # inches of title and axis
WIDTH = 6.4  # inches


def draw_differences(found: PairedStatistics, metric: str, ax: "Axes | None" = None) -> "Axes":
    """Draw the differences of a metric from the baseline, a row per policy, with 95 % intervals.

    Filled points differ significantly from the baseline, hollow ones do not.

    Parameters
    ----------
    found
        The statistics.
    metric
        One of `found.metrics`.
    ax
        Where to draw; a new figure if missing.

    Raises
    ------
    MissingExtraError
        If a new figure is needed and matplotlib is not installed.
    """
    if ax is None:
        with extra("plot"):
            import matplotlib.pyplot as plt

        size = (WIDTH, EDGES + INCHES * len(found.differences))
        ax = plt.figure(figsize=size, layout="constrained").add_subplot()
    for row, differences in enumerate(found.differences.values()):
        difference = differences[metric]
        lower, upper = difference.interval
        ax.errorbar(
            difference.mean,
            row,
            xerr=[[difference.mean - lower], [upper - difference.mean]],
            fmt="o",
            color=COLOURS[0],
            markerfacecolor=COLOURS[0] if difference.significant else "white",
            capsize=3,
        )
    ax.axvline(0.0, color="0.4", linewidth=1.0, linestyle="--", zorder=0)
    ax.set_yticks(range(len(found.differences)), list(found.differences))
    ax.set_ylim(len(found.differences) - 0.5, -0.5)  # the first policy on top
    ax.grid(axis="x", alpha=0.3)
    ax.set_title(metric.replace("_", " ").capitalize())
    ax.set_xlabel(
        f"minus {found.baseline}, per batch of {found.batch_size}\n"
        f"(mean over {found.batches} batches, {100 * CONFIDENCE:.0f} % interval)"
    )
    return ax
