"""All findings of a reproduction, computed from its numbers."""

from collections.abc import Sequence

from beltsort.paper.beyond_findings import beyond_findings
from beltsort.paper.claims import TOLERATED, claims
from beltsort.paper.instances import FOUR, OBJECTS, TWO
from beltsort.paper.labels import LEVEL as LABELS
from beltsort.paper.labels import STUDY
from beltsort.paper.outcomes import Row, only, select
from beltsort.paper.policies import DESPOT, OPTIMUM, THRESHOLD
from beltsort.paper.printed import R_MIN
from beltsort.paper.scans import LEVEL as SCANS
from beltsort.paper.statistics import difference, mean, saving, unpaired
from beltsort.paper.verdicts import Finding, in_words, verdict

TABLES = {"paper": "the paper's tables", "cell": "the simulated cell's tables"}


def all_findings(rows: Sequence[Row], beyond: Sequence[Row], optimum: Sequence[Row]) -> list[Finding]:
    """Return the findings, the main one first.

    Parameters
    ----------
    rows
        Of tables and scans, the optimum's included.
    beyond
        Of the further studies.
    optimum
        From `bound_optimum`.
    """
    found = [finding for where, shown in conditions(rows) for finding in claims(shown, where)]
    return [
        *found,
        *_optimum(rows, optimum),
        *(_planning(row) for row in optimum),
        *_levels(rows),
        *beyond_findings(beyond),
    ]


def conditions(rows: Sequence[Row]) -> list[tuple[str, list[Row]]]:
    """Return the rows by condition with its name; that of the main claim comes first."""
    groups: dict[tuple[str, str, str, float], list[Row]] = {}
    for row in select(rows, study=STUDY):
        key = (row["level"], row["instance"], row["objects"], row["discount"])
        groups.setdefault(key, []).append(row)
    order = {(LABELS, "paper", FOUR.name): 0, (LABELS, "paper", TWO.name): 1}
    keys = sorted(groups, key=lambda key: (order.get(key[:3], 2), key[0] == SCANS, abs(key[3] - 0.95)))
    return [(condition_name(*key), groups[key]) for key in keys]


def condition_name(level: str, instance: str, objects: str, discount: float) -> str:
    """Name a condition."""
    source = TABLES[instance] if level == LABELS else "the simulated cell"
    return f"{level} ({source}), {objects}, discount {discount:g}"


def _optimum(rows: Sequence[Row], optimum: Sequence[Row]) -> list[Finding]:
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
        f"solutions, two positions save {in_words(saved, ' %', factor=100)} of the steps."
    )
    return [Finding("even the best policy needs fewer steps", where, verdict(saved, 0.0), saved, text)]


def _planning(row: Row) -> Finding:
    """Hold DESPOT against the threshold policy: what their actions lose against the best ones."""
    planned, simple = (row["losses"][policy] for policy in (DESPOT, THRESHOLD))
    gained = difference(simple, planned)
    text = (
        f"At r_min = {row['r_min']:g}, positions seen: {row['positions']}, a batch of DESPOT's actions loses "
        f"{mean(planned).value:.3f} against the best ones (discounted reward), the threshold policy tuned on "
        f"other seeds {mean(simple).value:.3f}; planning gains {in_words(gained, digits=3)}."
    )
    claim = f"planning beats a tuned threshold, r_min = {row['r_min']:g}, positions: {row['positions']}"
    where = condition_name(LABELS, "paper", FOUR.name, row["discount"])
    return Finding(claim, where, verdict(gained, 0.0), gained, text)


def _levels(rows: Sequence[Row]) -> list[Finding]:
    """Hold depth scans against labels drawn from the tables that were estimated on the same cell."""
    found = []
    for objects in OBJECTS:
        for positions in (1, 2):
            wanted = {
                "instance": "cell", "objects": objects.name, "policy": DESPOT,
                "positions": positions, "r_min": R_MIN,
            }  # fmt: skip
            scans, labels = (only(rows, level=level, **wanted) for level in (SCANS, LABELS))
            gained = unpaired(scans["positives"], labels["positives"])
            text = (
                f"At r_min = {R_MIN:g}, positions seen: {positions}, sorting from depth scans makes "
                f"{mean(scans['positives']).value:.2f} right decisions of ten, labels drawn from its tables "
                f"{mean(labels['positives']).value:.2f}: a difference of {in_words(gained, digits=2)}. "
                "Repeated scans of one object are not independent, as the model takes them to be."
            )
            where = condition_name(SCANS, "cell", objects.name, scans["discount"])
            claim = f"scans sort as well as the tables say, positions: {positions}"
            found.append(Finding(claim, where, verdict(gained, -TOLERATED), gained, text))
    return found
