"""Every figure of the report, under the number that it has in the paper."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from beltsort.paper.curves import (
    accuracy_figure,
    beyond_figure,
    bounds_figure,
    one_against_two_figure,
    steps_figure,
)
from beltsort.paper.design import Design, Stream, seed_of
from beltsort.paper.instances import PAPER
from beltsort.paper.printed import R_MIN
from beltsort.paper.run import Results
from beltsort.paper.scans import PreparedCell, scan_point, sort_batch
from beltsort.paper.setup_figures import clouds_figure, propagation_figure, reached_sphere
from beltsort.paper.style import save_drawn, save_figure
from beltsort.sim import CellConfig
from beltsort.sorting.belief_figure import draw_belief
from beltsort.sorting.journal import Entry, read_journal
from beltsort.viewpoints.figure import draw_sphere


@dataclass(frozen=True)
class Picture:
    """The files of a figure.

    Attributes
    ----------
    name
        File name without ending.
    caption
        What it shows.
    """

    name: str
    caption: str


def draw_all(results: Results, design: Design, seed: int, folder: Path) -> list[Picture]:
    """Draw every figure as PNG and SVG into a folder, in the order of the report."""
    return [
        *_of_the_cell(results.cell, design, seed, folder),
        *_of_the_rows(results, design.discounts[0], folder),
    ]


def single_position_run(cell: PreparedCell, design: Design, seed: int) -> list[Entry]:
    """Sort ten bulbs from depth scans, seeing one position at a time; return the journal."""
    point = scan_point(design, seed_of(seed, Stream.RUN), cell, positions=1, r_min=R_MIN, batch=0)
    with TemporaryDirectory() as folder:
        journal = Path(folder) / "journal.sqlite"
        sort_batch(point, journal)
        return read_journal(journal)


def _of_the_cell(cell: PreparedCell, design: Design, seed: int, folder: Path) -> Iterator[Picture]:
    views, reached = reached_sphere()
    yield _drawn(
        lambda path: draw_sphere(views, path), folder, "figure_1_sphere",
        "Fig. 1: the half-sphere of viewpoints, the graph of neighbours, and three viewpoints far apart; "
        f"reachable is {reached}.",
    )  # fmt: skip
    save_figure(clouds_figure(CellConfig(), seed), folder, "figure_1_clouds")
    yield Picture("figure_1_clouds", "Fig. 1, continued: models of the classes, and candidates from scans.")
    save_figure(propagation_figure(PAPER.model), folder, "figure_2_propagation")
    yield Picture(
        "figure_2_propagation",
        "Fig. 2: how the belief is handed on: two scans, then the decision; what was learnt about the second "
        "position moves to the first, and a new object arrives behind it. Computed, not sketched.",
    )
    entries = single_position_run(cell, design, seed)
    yield _drawn(
        lambda path: draw_belief(entries, path), folder, "figure_3_run",
        f"Fig. 3: the belief over time in a run that sees one position, r_min = {R_MIN:g}, from depth scans; "
        "dashed lines are decisions.",
    )  # fmt: skip


def _of_the_rows(results: Results, discount: float, folder: Path) -> Iterator[Picture]:
    rows = results.rows
    drawn = [
        (
            "figure_4_one_position", accuracy_figure(rows, 1, discount),
            "Fig. 4: right and wrong decisions of ten, one position; curves stand a little aside of each "
            "other.",
        ),
        (
            "figure_5_two_positions", accuracy_figure(rows, 2, discount),
            "Fig. 5: the same, two positions.",
        ),
        (
            "figure_6_steps", steps_figure(rows, discount),
            "Fig. 6: steps to sort ten objects, one against two positions; the paper prints 52 steps in its "
            "series over r_min and 75 in its comparison, both with r_min = 50.",
        ),
        (
            "figure_7_one_against_two", one_against_two_figure(rows, discount),
            "Fig. 7: the planners' right and wrong decisions, one against two positions.",
        ),
        (
            "bounds", bounds_figure(results.optimum),
            "Certified bounds of the best possible value, and what each policy loses against the upper one; "
            "both depend on the machine's speed. Losses are of discounted reward.",
        ),
        (
            "beyond", beyond_figure(results.beyond),
            "Beyond the paper: a reward for information, more positions, a wrong table, the arrival prior.",
        ),
    ]  # fmt: skip
    for name, figure, caption in drawn:
        save_figure(figure, folder, name)
        yield Picture(name, caption)


def _drawn(draw: Callable[[Path], None], folder: Path, name: str, caption: str) -> Picture:
    save_drawn(draw, folder, name)
    return Picture(name, caption)
