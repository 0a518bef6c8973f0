"""The paper's claims, held against the rows of one condition.

References
----------
A. Mezei, L. Tamas, L. Busoniu, "Sorting objects from a conveyor belt using active perception with a POMDP
model", European Control Conference 2019, section on results.
"""

import math
from collections.abc import Sequence

from beltsort.paper.outcomes import Row, only, select
from beltsort.paper.policies import DESPOT
from beltsort.paper.printed import R_MIN
from beltsort.paper.statistics import Estimate, difference, saving, slope
from beltsort.paper.verdicts import Finding, in_words, verdict

WANTED_SAVING = 0.10
"""Share of the steps that two positions should save."""

TOLERATED = 0.1
"""Objects of ten by which accuracy may fall and still count as equal."""

POSITIONS = {1: "one position", 2: "two positions"}


def claims(rows: Sequence[Row], where: str, policy: str = DESPOT) -> list[Finding]:
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
    return [
        *_fewer_steps(one, two, where),
        _equal_accuracy(one, two, where),
        *(
            _grows(select(rows, policy=policy, positions=n), outcome, name, where, words)
            for n, words in POSITIONS.items()
            for outcome, name in (("positives", "accuracy"), ("steps", "steps"))
        ),
    ]


def _fewer_steps(one: Row, two: Row, where: str) -> list[Finding]:
    saved = saving(two["steps"], one["steps"])
    said = f"At r_min = {R_MIN:g}, two positions save {in_words(saved, ' %', factor=100)} of the steps"
    means = f": {_mean(two)} instead of {_mean(one)} for ten objects."
    return [
        Finding("two positions need fewer steps", where, verdict(saved, above=0.0), saved, f"{said}{means}"),
        Finding(
            f"two positions save at least {100 * WANTED_SAVING:.0f} % of the steps",
            where,
            verdict(saved, above=WANTED_SAVING),
            saved,
            f"{said}.",
        ),
    ]


def _mean(row: Row) -> str:
    return f"{sum(row['steps']) / len(row['steps']):.1f}"


def _equal_accuracy(one: Row, two: Row, where: str) -> Finding:
    gained = difference(two["positives"], one["positives"])
    text = (
        f"At r_min = {R_MIN:g}, two positions change the right decisions of ten by "
        f"{in_words(gained, digits=2)}; a loss below {TOLERATED:g} counts as equal."
    )
    return Finding("equal accuracy with two positions", where, verdict(gained, -TOLERATED), gained, text)


def _grows(rows: Sequence[Row], outcome: str, name: str, where: str, positions: str) -> Finding:
    growth = growth_per_decade(rows, outcome)
    text = f"With {positions}, {name} grow{'s' * (name == 'accuracy')} by {in_words(growth, digits=2)} "
    unit = "right decisions of ten" if outcome == "positives" else "steps"
    return Finding(
        f"{name} grow{'s' * (name == 'accuracy')} with r_min, {positions}",
        where,
        verdict(growth, above=0.0),
        growth,
        f"{text}{unit} for each tenfold r_min.",
    )


def growth_per_decade(rows: Sequence[Row], outcome: str) -> Estimate:
    """Return by how much an outcome grows for each tenfold r_min."""
    return slope([math.log10(row["r_min"]) for row in rows], [row[outcome] for row in rows])
