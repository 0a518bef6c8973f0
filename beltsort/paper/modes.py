"""The simulated cell sorted with modes and confidence levels, beside the plain tables that the paper has.

The paper's tables take looks at one object for independent. Tables with modes know that they are not
(docs/models.md), so what they promise should come true, and labels with confidence levels say more.
"""

from collections.abc import Iterator, Sequence

from beltsort.paper.design import Design
from beltsort.paper.instances import OBJECTS, Objects
from beltsort.paper.labels import label_point
from beltsort.paper.outcomes import LABELS, SCANS, Point, Row, only, select
from beltsort.paper.policies import PLANNERS, RECOMMENDED
from beltsort.paper.printed import R_MIN
from beltsort.paper.scans import PreparedCell, scan_points
from beltsort.paper.statistics import ClaimResult, conclude, difference, mean, saving, unpaired

STUDY = "modes"
WANTED_SAVING = 0.10
"""Share of the steps that modes and confidence levels should save."""

TOLERATED = 0.1
"""Objects of ten by which accuracy may fall and still count as equal."""


def mode_label_points(design: Design, seed: int, cell: PreparedCell) -> list[Point]:
    """Return the points with labels from the tables with modes: both planners, one and two positions."""
    if cell.modes is None:
        return []
    discount = design.discounts[0]
    return [
        label_point(
            design,
            seed,
            cell.modes.model.with_positions(positions).replace(r_min=R_MIN, discount=discount),
            objects,
            study=STUDY,
            instance=cell.modes.name,
            policy=policy,
        )
        for objects in OBJECTS
        for positions in (1, 2)
        for policy in PLANNERS
    ]


def mode_scan_points(design: Design, seed: int, cell: PreparedCell) -> list[Point]:
    """Return the points with depth scans and tables with modes, on the same batches as the plain tables."""
    if cell.with_modes is None:
        return []
    return [point | {"study": STUDY} for point in scan_points(design, seed, cell.with_modes, [R_MIN])]


def mode_claims(rows: Sequence[Row]) -> list[ClaimResult]:
    """Return what the rows say of tables with modes; nothing if there are no such rows."""
    if not select(rows, study=STUDY):
        return []
    return [
        result for objects in OBJECTS for positions in (1, 2) for result in _claims(rows, objects, positions)
    ]


def _claims(rows: Sequence[Row], objects: Objects, positions: int) -> Iterator[ClaimResult]:
    """Compare with what the tables promise, and with the plain tables on the same batches."""
    wanted = {"objects": objects.name, "policy": RECOMMENDED, "positions": positions, "r_min": R_MIN}
    scans, labels = (only(rows, study=STUDY, level=level, **wanted) for level in (SCANS, LABELS))
    plain = only(rows, level=SCANS, instance="cell", **wanted)
    where = f"{SCANS} (the simulated cell, modes and confidence levels), {objects.name}"
    at = f"At r_min = {R_MIN:g}, positions seen: {positions}"

    short = unpaired(scans["positives"], labels["positives"])
    yield ClaimResult(
        f"scans sort as well as tables with modes say, positions: {positions}",
        where,
        conclude(short, -TOLERATED),
        short,
        f"{at}, sorting from depth scans makes {mean(scans['positives']).value:.2f} right decisions of ten, "
        f"labels drawn from its tables {mean(labels['positives']).value:.2f}: a difference of "
        f"{short.in_words(digits=2)}.",
    )
    saved = saving(scans["steps"], plain["steps"])
    yield ClaimResult(
        f"modes save at least {100 * WANTED_SAVING:.0f} % of the steps, positions: {positions}",
        where,
        conclude(saved, WANTED_SAVING),
        saved,
        f"{at}, modes and confidence levels save {saved.in_words(' %', factor=100)} of the steps: "
        f"{mean(scans['steps']).value:.1f} instead of {mean(plain['steps']).value:.1f} for ten objects.",
    )
    gained = difference(scans["positives"], plain["positives"])
    yield ClaimResult(
        f"equal accuracy with modes, positions: {positions}",
        where,
        conclude(gained, -TOLERATED),
        gained,
        f"{at}, modes and confidence levels change the right decisions of ten by "
        f"{gained.in_words(digits=2)}; a loss below {TOLERATED:g} counts as equal.",
    )
