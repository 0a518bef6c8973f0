"""The results of a study as a figure."""

from pathlib import Path
from typing import TYPE_CHECKING

from beltsort.planning.bins import Estimate
from beltsort.planning.difference import half_interval
from beltsort.planning.throughput.study import Throughput
from beltsort.util.colours import COLOURS, MARKERS
from beltsort.util.figure_style import DPI, PAGE, column_style, empty_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@column_style()
def draw_throughput(found: Throughput, path: Path) -> None:
    """Draw least purity and right objects of each policy against the objects decided per minute.

    Parameters
    ----------
    found
        The results.
    path
        The picture; its ending (png, svg, pdf) is its format.

    Raises
    ------
    MissingExtraError
        If matplotlib is not installed.
    """
    figure = empty_figure(PAGE, PAGE * 0.4)
    left, right = figure.subplots(1, 2)
    for index, policy in enumerate(found.policies):
        results = found.of(policy)
        rates = [result.statistics.objects_per_minute for result in results]
        purities = [result.statistics.least_purity for result in results]
        _curve(left, rates, purities, policy, index)
        _curve(right, rates, [result.statistics.right for result in results], policy, index)
    left.axhline(found.purity, color="0.6", linewidth=0.6, linestyle="--")
    left.set(xlabel="objects decided per minute", ylabel="purity of the least pure bin")
    right.set(xlabel="objects decided per minute", ylabel="right, share of all objects")
    right.legend()
    figure.savefig(path, dpi=DPI)


def _curve(axes: "Axes", rates: list[Estimate | None], values: list[Estimate], name: str, index: int) -> None:
    axes.errorbar(
        [0.0 if rate is None else rate.value for rate in rates],
        [value.value for value in values],
        yerr=[half_interval(value.standard_error) for value in values],
        color=COLOURS[index % len(COLOURS)],
        marker=MARKERS[index % len(MARKERS)],
        markersize=3,
        linewidth=0.8,
        label=name,
    )
