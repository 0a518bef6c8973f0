"""Every figure of the report, under the number that it has in the paper."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from beltsort.paper.curves import (
    LOSS_FLOOR,
    accuracy_figure,
    beyond_figure,
    bounds_figure,
    one_against_two_figure,
    steps_figure,
)
from beltsort.paper.design import Design, Stream, seed_of
from beltsort.paper.files import Numbers
from beltsort.paper.instances import PAPER
from beltsort.paper.outcomes import Point
from beltsort.paper.printed import R_MIN
from beltsort.paper.scans import PreparedCell, scan_point, sort_batch, true_labels
from beltsort.paper.setup_figures import clouds_figure, propagation_figure, reached_sphere
from beltsort.paper.style import ERROR_BARS, save_figure
from beltsort.sim import CellConfig
from beltsort.sorting.belief_figure import belief_figure
from beltsort.sorting.journal import Entry, read_journal
from beltsort.viewpoints.figure import sphere_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure


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


SHARED = "All panels have the same scales, and no point is shifted."


def draw_all(numbers: Numbers, cell: PreparedCell, folder: Path) -> list[Picture]:
    """Draw every figure as PNG, SVG and PDF into a folder, in the order of the report."""
    about = numbers.circumstances
    pictures = []
    for name, figure, caption in (
        *_of_the_cell(cell, about.design, about.seed),
        *_of_the_rows(numbers, about.design.discounts[0]),
    ):
        save_figure(figure, folder, name)
        pictures.append(Picture(name, caption))
    return pictures


def single_position_run(cell: PreparedCell, design: Design, seed: int) -> list[Entry]:
    """Sort ten bulbs from depth scans, seeing one position at a time; return the journal."""
    with TemporaryDirectory() as folder:
        journal = Path(folder) / "journal.sqlite"
        sort_batch(_single_position_point(cell, design, seed), journal)
        return read_journal(journal)


def _single_position_point(cell: PreparedCell, design: Design, seed: int) -> Point:
    return scan_point(design, seed_of(seed, Stream.RUN), cell, positions=1, r_min=R_MIN, batch=0)


def _of_the_cell(cell: PreparedCell, design: Design, seed: int) -> "Iterator[tuple[str, Figure, str]]":
    views, reached = reached_sphere()
    yield (
        "figure_1_sphere", sphere_figure(views),
        "Fig. 1: the half-sphere of viewpoints, the graph of neighbours, and three viewpoints far apart; "
        f"reachable is {reached}.",
    )  # fmt: skip
    yield (
        "figure_1_clouds", clouds_figure(CellConfig(), seed),
        "Fig. 1, continued: models of the classes, and candidates from simulated scans; the boxes measure "
        "12 cm.",
    )  # fmt: skip
    yield (
        "figure_2_propagation", propagation_figure(PAPER.model),
        "Fig. 2: how the belief is handed on: two scans, then the decision; what was learnt about the second "
        "position moves to the first, and a new object arrives behind it. Computed, not sketched.",
    )  # fmt: skip
    model = cell.instance.model
    true = true_labels(_single_position_point(cell, design, seed), model.with_positions(1))
    entries = single_position_run(cell, design, seed)
    yield (
        "figure_3_run", belief_figure(entries, [model.classes[label] for label in true]),
        f"Fig. 3: the belief over time in a run that sees one position, r_min = {R_MIN:g}, from depth scans "
        "of the simulated cell. Dashed lines are decisions, after which the next object is at the belt end; "
        "above each object, the first letter of its true class and of the class decided, white on black "
        f"where that is wrong.",
    )  # fmt: skip


def _of_the_rows(numbers: Numbers, discount: float) -> "Iterator[tuple[str, Figure, str]]":
    rows = numbers.rows
    common = f"Discount {discount:g}. {ERROR_BARS}. {SHARED}"
    yield (
        "figure_4_one_position", accuracy_figure(rows, 1, discount),
        f"Fig. 4: right (filled) and wrong (hollow) decisions of ten, one position. {common}",
    )  # fmt: skip
    yield (
        "figure_5_two_positions", accuracy_figure(rows, 2, discount),
        f"Fig. 5: right (filled) and wrong (hollow) decisions of ten, two positions. {common}",
    )  # fmt: skip
    yield (
        "figure_6_steps", steps_figure(rows, discount),
        "Fig. 6: steps to sort ten objects, one position (filled, solid lines) and two (hollow, dashed). The "
        "paper prints 52 steps in its series over r_min and 75 in its comparison, both with r_min = 50. "
        f"{common}",
    )  # fmt: skip
    yield (
        "figure_7_one_against_two", one_against_two_figure(rows, discount),
        "Fig. 7: the planners' right (filled) and wrong (hollow) decisions of ten, one against two "
        f"positions. {common}",
    )  # fmt: skip
    yield (
        "bounds", bounds_figure(numbers.optimum),
        "Certified bounds of the best possible value (paper's tables), and what each policy loses against "
        "the upper one; both depend on the machine's speed. Losses are of discounted reward per batch; "
        f"smaller ones than {LOSS_FLOOR:g} are drawn there. {ERROR_BARS}.",
    )  # fmt: skip
    yield (
        "beyond", beyond_figure(numbers.beyond),
        "Beyond the paper (paper's tables, r_min = 50): a reward for information, more positions, a wrong "
        f"table, the arrival prior. The scale of right decisions does not begin at 0. {ERROR_BARS}.",
    )  # fmt: skip
