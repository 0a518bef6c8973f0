"""The paper's claims and further ones, each tested on the rows of one condition.

References
----------
A. Mezei, L. Tamas, L. Busoniu, "Sorting objects from a conveyor belt using active perception with a POMDP
model", European Control Conference 2019, section on results.
"""

import math
from collections.abc import Iterator, Sequence

from beltsort.paper.beyond import beyond_claims
from beltsort.paper.instances import FOUR, OBJECTS, TWO
from beltsort.paper.modes import TOLERATED, mode_claims
from beltsort.paper.moving import moving_claims
from beltsort.paper.outcomes import LABELS, SCANS, Row, only, select
from beltsort.paper.outline import THE_PAPER, Outline, positions_in_words
from beltsort.paper.policies import OPTIMUM, PLANNERS, PUBLISHED, RECOMMENDED, THRESHOLD
from beltsort.paper.printed import R_MIN
from beltsort.paper.statistics import ClaimResult, conclude, difference, mean, saving, slope, unpaired

WANTED_SAVING = 0.10
"""Share of the steps that two positions should save."""


def all_claims(
    rows: Sequence[Row],
    beyond: Sequence[Row],
    optimum: Sequence[Row],
    outline: Outline = THE_PAPER,
    moving: Sequence[Row] = (),
) -> list[ClaimResult]:
    """Return what all rows say of all claims, the main one first.

    Parameters
    ----------
    rows
        Of tables and scans, the optimum's included.
    beyond
        Of the further studies.
    optimum
        From `bound_optimum`.
    outline
        What was varied; claims that do not apply to it are left out.
    moving
        Of belts that never stop, from `beltsort.paper.moving.moving_table`.
    """
    return [
        *(
            result
            for where, shown in conditions(rows, outline)
            for policy in outline.judged
            if select(shown, policy=policy)
            for result in claims(shown, f"{where}, {policy}", policy, outline)
        ),
        *_optimum(rows, optimum, outline),
        *(result for row in optimum for result in _planning(row, outline)),
        *(_levels(rows) if select(rows, level=SCANS) else []),
        *mode_claims(rows),
        *beyond_claims(beyond),
        *moving_claims(moving),
    ]


def conditions(rows: Sequence[Row], outline: Outline = THE_PAPER) -> list[tuple[str, list[Row]]]:
    """Return the name and the rows of each condition; that of the main claim comes first."""
    groups: dict[tuple[str, str, str, float], list[Row]] = {}
    for row in select(rows, study=outline.name):
        key = (row["level"], row["instance"], row["objects"], row["discount"])
        groups.setdefault(key, []).append(row)
    order = {(LABELS, "paper", FOUR.name): 0, (LABELS, "paper", TWO.name): 1}
    keys = sorted(groups, key=lambda key: (order.get(key[:3], 2), key[0] == SCANS, abs(key[3] - 0.95)))
    return [(condition_name(*key, outline), groups[key]) for key in keys]


def condition_name(
    level: str, instance: str, objects: str, discount: float, outline: Outline = THE_PAPER
) -> str:
    """Return a condition in words."""
    source = outline.tables[instance] if level == LABELS else "the simulated cell"
    return f"{level} ({source}), {objects}, discount {discount:g}"


def claims(
    rows: Sequence[Row], where: str, policy: str = RECOMMENDED, outline: Outline = THE_PAPER
) -> list[ClaimResult]:
    """Return what the rows of one condition say of the paper's claims.

    Parameters
    ----------
    rows
        One level, one instance, one set of objects, one discount; all positions, several penalties.
    where
        Names the condition.
    policy
        Whose rows.
    outline
        What was varied.
    """
    own = [row for row in rows if row["policy"] == policy]
    return [
        *(_more_positions(own, where, outline) if len(outline.positions) > 1 else []),
        *(_gains_on_recommended(rows, where, policy, outline) if policy in outline.own_policies else []),
        *(
            _growth(select(own, positions=n), outcome, where, positions_in_words(n))
            for n in outline.positions
            for outcome in ("positives", "steps")
        ),
    ]


def _more_positions(rows: Sequence[Row], where: str, outline: Outline) -> list[ClaimResult]:
    """Compare the most positions with the fewest, batch by batch."""
    least, most = outline.positions[0], outline.positions[-1]
    few, many = (only(rows, positions=n, r_min=outline.r_min) for n in (least, most))
    seen, at = positions_in_words(most), f"At r_min = {outline.r_min:g}"
    saved = saving(many["steps"], few["steps"])
    saves = f"{at}, {seen} save {saved.in_words(' %', factor=100)} of the steps"
    with_few, with_many = (mean(row["steps"]).value for row in (few, many))
    gained = difference(many["positives"], few["positives"])
    fewer = ClaimResult(
        f"{seen} need fewer steps",
        where,
        conclude(saved, above=0.0),
        saved,
        f"{saves}: {with_many:.1f} instead of {with_few:.1f} for ten objects.",
    )
    wanted = ClaimResult(
        f"{seen} save at least {100 * WANTED_SAVING:.0f} % of the steps",
        where,
        conclude(saved, above=WANTED_SAVING),
        saved,
        f"{saves}.",
    )
    equal = ClaimResult(
        f"equal accuracy with {seen}",
        where,
        conclude(gained, above=-TOLERATED),
        gained,
        f"{at}, {seen} change the right decisions of ten by {gained.in_words(digits=2)}; a loss below "
        f"{TOLERATED:g} counts as equal.",
    )
    return [fewer, wanted, equal]


def _gains_on_recommended(
    rows: Sequence[Row], where: str, policy: str, outline: Outline
) -> Iterator[ClaimResult]:
    """Compare the rewards of a policy of one's own with those of the recommended planner, batch by batch."""
    for positions in outline.positions:
        wanted = {"positions": positions, "r_min": outline.r_min}
        own, recommended = (only(rows, policy=name, **wanted) for name in (policy, RECOMMENDED))
        gained, steps, right = (
            difference(own[outcome], recommended[outcome]) for outcome in ("returns", "steps", "positives")
        )
        text = (
            f"At r_min = {outline.r_min:g}, positions seen: {positions}, {policy} changes the reward per "
            f"batch of ten by {gained.in_words(digits=2)} against {RECOMMENDED}, the steps by "
            f"{steps.in_words(digits=2)} and the right decisions by {right.in_words(digits=2)}."
        )
        claim = f"it earns more than {RECOMMENDED}, positions: {positions}"
        yield ClaimResult(claim, where, conclude(gained, 0.0), gained, text)


def _growth(rows: Sequence[Row], outcome: str, where: str, positions: str) -> ClaimResult:
    """Test whether an outcome grows with r_min, by its slope over the decades of r_min."""
    growth = slope([math.log10(row["r_min"]) for row in rows], [row[outcome] for row in rows])
    grows, unit = {
        "positives": ("accuracy grows", "right decisions of ten"),
        "steps": ("steps grow", "steps"),
    }[outcome]
    return ClaimResult(
        f"{grows} with r_min, {positions}",
        where,
        conclude(growth, above=0.0),
        growth,
        f"With {positions}, {grows} by {growth.in_words(digits=2)} {unit} for each tenfold r_min.",
    )


def _optimum(rows: Sequence[Row], optimum: Sequence[Row], outline: Outline) -> Iterator[ClaimResult]:
    """Compare the steps of the offline solutions with the fewest and with the most positions."""
    solved = sorted({row["positions"] for row in optimum})
    if len(solved) < 2:
        return
    at, objects = f"r_min = {outline.r_min:g}", outline.objects[-1].name
    wanted = {"policy": OPTIMUM, "objects": objects, "r_min": outline.r_min}
    few, many = (only(rows, positions=n, **wanted) for n in (solved[0], solved[-1]))
    saved = saving(many["steps"], few["steps"])
    where = condition_name(LABELS, few["instance"], objects, few["discount"], outline)
    bounds = [
        f"{row['lower']:.2f} to {row['upper']:.2f} with {row['positions']} position"
        + "s" * (row["positions"] > 1)
        for row in select(optimum, r_min=outline.r_min)
    ]
    text = (
        f"The best possible value at {at} is certified to be {', '.join(bounds)}; acting by the solutions, "
        f"{positions_in_words(solved[-1])} save {saved.in_words(' %', factor=100)} of the steps."
    )
    yield ClaimResult("even the best policy needs fewer steps", where, conclude(saved, 0.0), saved, text)


def _planning(row: Row, outline: Outline) -> list[ClaimResult]:
    """Compare what the actions of policies lose, with the threshold policy's and with each other's."""
    where = condition_name(LABELS, row["instance"], row["objects"], row["discount"], outline)
    beats_threshold = "planning beats a tuned threshold"
    published = [PUBLISHED] if PUBLISHED in row["losses"] else []
    return [
        *(
            _loses_less(row, name, THRESHOLD, beats_threshold, f"{where}, {name}")
            for name in PLANNERS
            if name in row["losses"]
        ),
        *(
            _loses_less(row, RECOMMENDED, name, f"{RECOMMENDED} beats {name}", where)
            for name in (*published, *outline.own_policies)
        ),
    ]


def _loses_less(row: Row, policy: str, other: str, claim: str, where: str) -> ClaimResult:
    """Test whether the actions of one policy lose less than those of another, batch by batch."""
    lost, lost_by_other = (row["losses"][name] for name in (policy, other))
    gained = difference(lost_by_other, lost)
    named = "the threshold policy tuned on other seeds" if other == THRESHOLD else other
    text = (
        f"At r_min = {row['r_min']:g}, positions seen: {row['positions']}, the actions of a batch lose "
        f"{mean(lost).value:.3f} against the best ones (discounted reward) with {policy}, and "
        f"{mean(lost_by_other).value:.3f} with {named}; the former gains {gained.in_words(digits=3)}."
    )
    claim = f"{claim}, r_min = {row['r_min']:g}, positions: {row['positions']}"
    return ClaimResult(claim, where, conclude(gained, 0.0), gained, text)


def _levels(rows: Sequence[Row]) -> list[ClaimResult]:
    """Compare depth scans with labels drawn from the tables that were estimated on the same cell."""
    found = []
    for objects in OBJECTS:
        for positions in (1, 2):
            wanted = {
                "instance": "cell", "objects": objects.name, "policy": RECOMMENDED,
                "positions": positions, "r_min": R_MIN,
            }  # fmt: skip
            scans, labels = (only(rows, level=level, **wanted) for level in (SCANS, LABELS))
            gained = unpaired(scans["positives"], labels["positives"])
            text = (
                f"At r_min = {R_MIN:g}, positions seen: {positions}, sorting from depth scans makes "
                f"{mean(scans['positives']).value:.2f} right decisions of ten, labels drawn from its tables "
                f"{mean(labels['positives']).value:.2f}: a difference of {gained.in_words(digits=2)}. "
                "Repeated scans of one object are not independent, as the model takes them to be."
            )
            where = condition_name(SCANS, "cell", objects.name, scans["discount"])
            claim = f"scans sort as well as the tables say, positions: {positions}"
            found.append(ClaimResult(claim, where, conclude(gained, -TOLERATED), gained, text))
    return found
