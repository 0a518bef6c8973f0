"""Every figure of the report, under the number that it has in the paper."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from beltsort.paper.curves import (
    LOSS_FLOOR,
    accuracy_figure,
    beyond_figure,
    bounds_figure,
    moving_figure,
    one_against_two_figure,
    steps_figure,
)
from beltsort.paper.design import Design, Stream, seed_of
from beltsort.paper.files import Numbers
from beltsort.paper.instances import PAPER
from beltsort.paper.outcomes import Point
from beltsort.paper.outline import positions_in_words
from beltsort.paper.policies import RECOMMENDED
from beltsort.paper.printed import R_MIN
from beltsort.paper.scans import PreparedCell, scan_point, sort_batch, true_labels
from beltsort.paper.setup_figures import clouds_figure, propagation_figure, reached_sphere
from beltsort.paper.style import ERROR_BARS, save_figure
from beltsort.planning.throughput import PURITY
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


ACCURACY = {1: (4, "figure_4_one_position"), 2: (5, "figure_5_two_positions")}
"""Number and name of the figures of right and wrong decisions, by the number of positions."""

PRINTED_STEPS = (
    "The paper prints 52 steps in its series over r_min and 75 in its comparison, both with r_min = 50. "
)
SHARED = "All panels have the same scales, and no point is shifted."


def draw_all(numbers: Numbers, cell: PreparedCell | None, folder: Path) -> list[Picture]:
    """Draw every figure as PNG, SVG and PDF into a folder, in the order of the report.

    Without a cell, figures 1 to 3 are left out.
    """
    about = numbers.circumstances
    pictures = []
    for name, figure, caption in (
        *(_of_the_cell(cell, about.design, about.seed) if cell is not None else ()),
        *_of_the_rows(numbers),
        *_of_the_optimum(numbers),
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


def _of_the_rows(numbers: Numbers) -> "Iterator[tuple[str, Figure, str]]":
    rows, outline = numbers.rows, numbers.circumstances.outline
    discount = numbers.circumstances.design.discounts[0]
    common = f"Discount {discount:g}. {ERROR_BARS}."
    as_in = "" if outline.of_the_paper else "As the paper's "
    if outline.of_the_paper:
        common += f" {SHARED}"
    for positions in outline.positions:
        seen = positions_in_words(positions)
        number, name = ACCURACY.get(positions, (5, f"accuracy_{positions}_positions"))
        yield (
            name, accuracy_figure(rows, positions, discount, outline),
            f"{as_in}Fig. {number}: right (filled) and wrong (hollow) decisions of ten, {seen}. {common}",
        )  # fmt: skip
    yield (
        "figure_6_steps", steps_figure(rows, discount, outline),
        f"{as_in}Fig. 6: steps to sort ten objects, {_lines_in_words(outline.positions)}. "
        f"{PRINTED_STEPS if outline.of_the_paper else ''}{common}",
    )  # fmt: skip
    if len(outline.positions) > 1:
        least, most = (positions_in_words(outline.positions[place]) for place in (0, -1))
        who = "the planners'" if not outline.own_policies else f"{RECOMMENDED}'s and your policies'"
        yield (
            "figure_7_one_against_two", one_against_two_figure(rows, discount, outline),
            f"{as_in}Fig. 7: {who} right (filled) and wrong (hollow) decisions of ten, "
            f"{least.removesuffix(' position')} against {most}. {common}",
        )  # fmt: skip


def _lines_in_words(positions: Sequence[int]) -> str:
    """Return how Fig. 6 draws each number of positions."""
    first, *others = (positions_in_words(number) for number in positions)
    if not others:
        return first
    if len(others) == 1:
        return f"{first} (filled, solid lines) and {others[0].removesuffix(' positions')} (hollow, dashed)"
    return f"{first} (filled, solid lines) and {', '.join(others)} (hollow; the legend names their lines)"


def _of_the_optimum(numbers: Numbers) -> "Iterator[tuple[str, Figure, str]]":
    outline = numbers.circumstances.outline
    tables = outline.tables[outline.sources[0].instance]
    if numbers.optimum:
        yield (
            "bounds", bounds_figure(numbers.optimum, outline),
            f"Certified bounds of the best possible value ({tables.removeprefix('the ')}), and what each "
            "policy loses against the upper one; both depend on the machine's speed. Losses are of "
            f"discounted reward per batch; smaller ones than {LOSS_FLOOR:g} are drawn there. {ERROR_BARS}.",
        )  # fmt: skip
    if numbers.beyond:
        yield (
            "beyond", beyond_figure(numbers.beyond),
            "Beyond the paper (paper's tables, r_min = 50): a reward for information, more positions, a "
            "wrong table, the arrival prior. The scale of right decisions does not begin at 0. "
            f"{ERROR_BARS}.",
        )  # fmt: skip
    if numbers.moving:
        speeds = dict.fromkeys(f"{row['places_per_minute']:.3g}" for row in numbers.moving)
        yield (
            "moving", moving_figure(numbers.moving),
            "A belt that never stops, and stop-and-go (paper's tables): purity of the least pure bin and the "
            "share of all objects sorted right, against objects decided per minute. Curves join belt speeds "
            f"of {', '.join(speeds)} places per minute; the dotted line is a purity of {PURITY:g}. The scale "
            f"of purity does not begin at 0. {ERROR_BARS}.",
        )  # fmt: skip
