"""Experiments that the paper does not have, with labels drawn from tables, and what they show."""

from collections.abc import Sequence
from itertools import pairwise

from beltsort.paper.design import Design
from beltsort.paper.instances import FOUR, PAPER, TWO, sharpened, with_arrival, with_more_positions
from beltsort.paper.labels import label_point
from beltsort.paper.outcomes import Point, Row, only
from beltsort.paper.policies import PLANNERS
from beltsort.paper.statistics import ClaimResult, Estimate, conclude, difference, saving

BONUS, POSITIONS, SHARPNESS, ARRIVAL = "information bonus", "positions seen", "wrong table", "arrival prior"
STUDIES = {
    BONUS: "reward per nat of information",
    POSITIONS: "belt positions seen at once",
    SHARPNESS: "exponent of the believed tables (1: right)",
    ARRIVAL: "share of the prior on the two classes",
}
"""Names of the studies, and of what each varies."""

BASES = {BONUS: 0.0, SHARPNESS: 1.0, ARRIVAL: 0.0}
"""The setting that the others of a study are compared with."""

WHERE = "labels from tables (the paper's tables), {policy}, r_min = 50"


def beyond_points(design: Design, seed: int) -> list[Point]:
    """Return the points of all studies, at the paper's middle penalty.

    The bonus is studied with the recommended planner only: the published one cannot plan with it.
    """
    one_and_two_positions = (PAPER.model.with_positions(1), PAPER.model)

    bonuses = [
        label_point(
            design, seed, PAPER.model.replace(information_gain=bonus), FOUR, study=BONUS, setting=bonus
        )
        for bonus in design.bonuses
    ]
    positions = [
        label_point(
            design, seed, with_more_positions(PAPER.model, number), FOUR,
            study=POSITIONS, setting=float(number), policy=planner,
        )
        for planner in PLANNERS
        for number in design.positions
    ]  # fmt: skip
    wrong_tables = [
        label_point(
            design, seed, sharpened(truth, exponent), FOUR,
            study=SHARPNESS, setting=exponent, truth=truth.to_json(), policy=planner,
        )
        for planner in PLANNERS
        for truth in one_and_two_positions
        for exponent in design.sharpness
    ]  # fmt: skip
    arrivals = [
        label_point(
            design, seed, with_arrival(model, TWO, share), TWO, study=ARRIVAL, setting=share, policy=planner
        )
        for planner in PLANNERS
        for model in one_and_two_positions
        for share in design.arrivals
    ]
    return [*bonuses, *positions, *wrong_tables, *arrivals]


def beyond_claims(rows: Sequence[Row]) -> list[ClaimResult]:
    """Compare each setting of a study with the study's base, and each number of positions with one fewer."""
    return [
        result
        for planner in PLANNERS
        for result in _claims_of_planner([row for row in rows if row["policy"] == planner])
    ]


def _claims_of_planner(rows: Sequence[Row]) -> list[ClaimResult]:
    found = []
    for study, base_setting in BASES.items():
        shown = [row for row in rows if row["study"] == study]
        for row in shown:
            if row["setting"] != base_setting:
                base = only(shown, setting=base_setting, positions=row["positions"])
                found.append(_compared_with_base(row, base))
    by_positions = sorted(
        (row for row in rows if row["study"] == POSITIONS), key=lambda row: int(row["positions"])
    )
    return [*found, *(_one_more_position(fewer, more) for fewer, more in pairwise(by_positions))]


def _compared_with_base(row: Row, base: Row) -> ClaimResult:
    """Compare the rewards of a setting with those of the base, batch by batch."""
    gained = difference(row["returns"], base["returns"])
    steps = difference(row["steps"], base["steps"])
    positives = difference(row["positives"], base["positives"])
    changes = (
        f"changes the reward per batch (bonuses apart) by {gained.in_words(digits=2)}, the steps "
        f"by {steps.value:+.2f} and the right decisions of ten by {positives.value:+.2f}"
    )
    setting, positions, where = row["setting"], row["positions"], WHERE.format(**row)
    if row["study"] == BONUS:
        claim = f"a bonus of {setting:g} per nat of information earns more"
        text = f"A bonus of {setting:g} per nat of information that a scan is expected to give {changes}."
        return ClaimResult(claim, where, conclude(gained, 0.0), gained, text)
    if row["study"] == SHARPNESS:
        lost = Estimate(-gained.value, gained.standard_error, gained.n)
        kind = "too good" if setting > 1.0 else "too poor"
        claim = f"a table {kind} (exponent {setting:g}) costs reward, positions: {positions}"
        text = (
            f"Believing a table that is {kind} (rows raised to {setting:g}), positions seen: {positions}, "
            f"{changes}."
        )
        return ClaimResult(claim, where, conclude(lost, 0.0), lost, text)
    share = f"{100 * setting:.0f} % of the arrival prior"
    claim = f"{share} on the two classes earns more, positions: {positions}"
    text = (
        f"With {share} on the two classes that come instead of a uniform one, positions seen: {positions}: "
        f"this {changes}."
    )
    return ClaimResult(claim, where, conclude(gained, 0.0), gained, text)


def _one_more_position(fewer: Row, more: Row) -> ClaimResult:
    saved = saving(more["steps"], fewer["steps"])
    gained = difference(more["positives"], fewer["positives"])
    where = WHERE.format(**more)
    claim = f"{more['positions']} positions need fewer steps than {fewer['positions']}"
    text = (
        f"{more['positions']} positions save {saved.in_words(' %', factor=100)} of the steps over "
        f"{fewer['positions']}, and change the right decisions of ten by {gained.in_words(digits=2)}; "
        "positions beyond the second have made-up tables, ever nearer to chance."
    )
    return ClaimResult(claim, where, conclude(saved, 0.0), saved, text)
