"""The paper's claims and further ones, each tested on the rows of one condition.

References
----------
A. Mezei, L. Tamas, L. Busoniu, "Sorting objects from a conveyor belt using active perception with a POMDP
model", European Control Conference 2019, section on results.
"""

import math
from collections.abc import Sequence

from beltsort.paper.beyond import beyond_claims
from beltsort.paper.instances import FOUR, OBJECTS, TWO
from beltsort.paper.labels import LEVEL as LABELS
from beltsort.paper.labels import STUDY
from beltsort.paper.modes import TOLERATED, mode_claims
from beltsort.paper.outcomes import Row, only, select
from beltsort.paper.policies import OPTIMUM, PLANNERS, PUBLISHED, RECOMMENDED, THRESHOLD
from beltsort.paper.printed import R_MIN
from beltsort.paper.scans import LEVEL as SCANS
from beltsort.paper.statistics import ClaimResult, conclude, difference, mean, saving, slope, unpaired

WANTED_SAVING = 0.10
"""Share of the steps that two positions should save."""

POSITIONS = {1: "one position", 2: "two positions"}
TABLES = {"paper": "the paper's tables", "cell": "the simulated cell's tables"}


def all_claims(rows: Sequence[Row], beyond: Sequence[Row], optimum: Sequence[Row]) -> list[ClaimResult]:
    """Return what all rows say of all claims, the main one first.

    Parameters
    ----------
    rows
        Of tables and scans, the optimum's included.
    beyond
        Of the further studies.
    optimum
        From `bound_optimum`.
    """
    return [
        *(
            result
            for where, shown in conditions(rows)
            for planner in PLANNERS
            if select(shown, policy=planner)
            for result in claims(shown, f"{where}, {planner}", planner)
        ),
        _optimum(rows, optimum),
        *(result for row in optimum for result in _planning(row)),
        *_levels(rows),
        *mode_claims(rows),
        *beyond_claims(beyond),
    ]


def conditions(rows: Sequence[Row]) -> list[tuple[str, list[Row]]]:
    """Return the name and the rows of each condition; that of the main claim comes first."""
    groups: dict[tuple[str, str, str, float], list[Row]] = {}
    for row in select(rows, study=STUDY):
        key = (row["level"], row["instance"], row["objects"], row["discount"])
        groups.setdefault(key, []).append(row)
    order = {(LABELS, "paper", FOUR.name): 0, (LABELS, "paper", TWO.name): 1}
    keys = sorted(groups, key=lambda key: (order.get(key[:3], 2), key[0] == SCANS, abs(key[3] - 0.95)))
    return [(condition_name(*key), groups[key]) for key in keys]


def condition_name(level: str, instance: str, objects: str, discount: float) -> str:
    """Return a condition in words."""
    source = TABLES[instance] if level == LABELS else "the simulated cell"
    return f"{level} ({source}), {objects}, discount {discount:g}"


def claims(rows: Sequence[Row], where: str, policy: str = RECOMMENDED) -> list[ClaimResult]:
    """Return what the rows of one condition say of the paper's claims.

    Parameters
    ----------
    rows
        One level, one instance, one set of objects, one discount; one and two positions, several penalties.
    where
        Names the condition.
    policy
        Whose rows.
    """
    one, two = (only(rows, policy=policy, positions=n, r_min=R_MIN) for n in POSITIONS)
    saved = saving(two["steps"], one["steps"])
    saves = f"At r_min = {R_MIN:g}, two positions save {saved.in_words(' %', factor=100)} of the steps"
    with_one, with_two = (mean(row["steps"]).value for row in (one, two))
    gained = difference(two["positives"], one["positives"])
    return [
        ClaimResult(
            "two positions need fewer steps",
            where,
            conclude(saved, above=0.0),
            saved,
            f"{saves}: {with_two:.1f} instead of {with_one:.1f} for ten objects.",
        ),
        ClaimResult(
            f"two positions save at least {100 * WANTED_SAVING:.0f} % of the steps",
            where,
            conclude(saved, above=WANTED_SAVING),
            saved,
            f"{saves}.",
        ),
        ClaimResult(
            "equal accuracy with two positions",
            where,
            conclude(gained, above=-TOLERATED),
            gained,
            f"At r_min = {R_MIN:g}, two positions change the right decisions of ten by "
            f"{gained.in_words(digits=2)}; a loss below {TOLERATED:g} counts as equal.",
        ),
        *(
            _growth(select(rows, policy=policy, positions=n), outcome, where, words)
            for n, words in POSITIONS.items()
            for outcome in ("positives", "steps")
        ),
    ]


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


def _optimum(rows: Sequence[Row], optimum: Sequence[Row]) -> ClaimResult:
    """Compare the steps of the offline solutions with one and with two positions."""
    wanted = {"policy": OPTIMUM, "objects": FOUR.name, "r_min": R_MIN}
    one, two = (only(rows, positions=n, **wanted) for n in (1, 2))
    saved = saving(two["steps"], one["steps"])
    where = condition_name(LABELS, "paper", FOUR.name, one["discount"])
    bounds = [
        f"{row['lower']:.2f} to {row['upper']:.2f} with {row['positions']} position"
        + "s" * (row["positions"] > 1)
        for row in select(optimum, r_min=R_MIN)
    ]
    text = (
        f"The best possible value at r_min = {R_MIN:g} is certified to be {', '.join(bounds)}; acting by the "
        f"solutions, two positions save {saved.in_words(' %', factor=100)} of the steps."
    )
    return ClaimResult("even the best policy needs fewer steps", where, conclude(saved, 0.0), saved, text)


def _planning(row: Row) -> list[ClaimResult]:
    """Compare what the planners' actions lose with what the threshold policy's lose, and with each other."""
    where = condition_name(LABELS, "paper", FOUR.name, row["discount"])
    beats_threshold = "planning beats a tuned threshold"
    return [
        *(_loses_less(row, name, THRESHOLD, beats_threshold, f"{where}, {name}") for name in PLANNERS),
        _loses_less(row, RECOMMENDED, PUBLISHED, f"{RECOMMENDED} beats {PUBLISHED}", where),
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
