"""What the studies beyond the paper say."""

from collections.abc import Sequence
from itertools import pairwise

from beltsort.paper.beyond import ARRIVAL, BONUS, POSITIONS, SHARPNESS
from beltsort.paper.outcomes import Row, only
from beltsort.paper.statistics import Estimate, difference, saving
from beltsort.paper.verdicts import Finding, in_words, verdict

WHERE = "labels from tables (the paper's tables), DESPOT, r_min = 50"


def beyond_findings(rows: Sequence[Row]) -> list[Finding]:
    """Hold each setting of each study against the study's base, batch by batch."""
    return [
        *(_bonus(row, base) for row, base in _pairs(rows, BONUS, 0.0)),
        *(_wrong_table(row, base) for row, base in _pairs(rows, SHARPNESS, 1.0)),
        *(_arrival(row, base) for row, base in _pairs(rows, ARRIVAL, 0.0)),
        *_more_positions(rows),
    ]


def _pairs(rows: Sequence[Row], study: str, base: float) -> list[tuple[Row, Row]]:
    """Return each row of a study with the row of its base."""
    shown = [row for row in rows if row["study"] == study]
    return [
        (row, only(shown, setting=base, positions=row["positions"]))
        for row in shown
        if row["setting"] != base
    ]


def _returns(row: Row, base: Row) -> tuple[Estimate, str]:
    gained = difference(row["returns"], base["returns"])
    steps = difference(row["steps"], base["steps"])
    positives = difference(row["positives"], base["positives"])
    return gained, (
        f"changes the reward per batch (bonuses apart) by {in_words(gained, digits=2)}, the steps "
        f"by {steps.value:+.2f} and the right decisions of ten by {positives.value:+.2f}"
    )


def _bonus(row: Row, base: Row) -> Finding:
    gained, words = _returns(row, base)
    claim = f"a bonus of {row['setting']:g} per nat of information earns more"
    text = f"A bonus of {row['setting']:g} per nat of information that a scan is expected to give {words}."
    return Finding(claim, WHERE, verdict(gained, 0.0), gained, text)


def _wrong_table(row: Row, base: Row) -> Finding:
    gained, words = _returns(row, base)
    lost = Estimate(-gained.value, gained.standard_error, gained.n)
    kind = "too good" if row["setting"] > 1.0 else "too poor"
    claim = f"a table {kind} (exponent {row['setting']:g}) costs reward, positions: {row['positions']}"
    text = (
        f"Believing a table that is {kind} (rows raised to {row['setting']:g}), positions seen: "
        f"{row['positions']}, {words}."
    )
    return Finding(claim, WHERE, verdict(lost, 0.0), lost, text)


def _arrival(row: Row, base: Row) -> Finding:
    gained, words = _returns(row, base)
    share = f"{100 * row['setting']:.0f} % of the arrival prior"
    claim = f"{share} on the two classes earns more, positions: {row['positions']}"
    text = (
        f"With {share} on the two classes that come instead of a uniform one, positions seen: "
        f"{row['positions']}: this {words}."
    )
    return Finding(claim, WHERE, verdict(gained, 0.0), gained, text)


def _more_positions(rows: Sequence[Row]) -> list[Finding]:
    """Hold each number of positions against one fewer."""
    shown = sorted((row for row in rows if row["study"] == POSITIONS), key=lambda row: int(row["positions"]))
    found = []
    for fewer, more in pairwise(shown):
        saved = saving(more["steps"], fewer["steps"])
        gained = difference(more["positives"], fewer["positives"])
        text = (
            f"{more['positions']} positions save {in_words(saved, ' %', factor=100)} of the steps over "
            f"{fewer['positions']}, and change the right decisions of ten by {in_words(gained, digits=2)}; "
            "positions beyond the second have made-up tables, ever nearer to chance."
        )
        claim = f"{more['positions']} positions need fewer steps than {fewer['positions']}"
        found.append(Finding(claim, WHERE, verdict(saved, 0.0), saved, text))
    return found
