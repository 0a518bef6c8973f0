"""Observation tables as text, laid out as in the paper's Tables I and II.

References
----------
A. Mezei, L. Tamas, L. Busoniu, "Sorting objects from a conveyor belt using active perception with a POMDP
model", European Control Conference 2019.
"""

from collections.abc import Sequence

from beltsort.tables.counts import Array, Counts
from beltsort.tables.independence import IndependenceTest
from beltsort.tables.intervals import credible_intervals
from beltsort.util.text import position_number


def table_one(
    p_obs: Array,
    classes: Sequence[str],
    viewpoints: Sequence[str],
    true: int,
    labels: Sequence[str] | None = None,
) -> str:
    """Return the paper's Table I for one true class at the belt end: a row for each viewpoint.

    Parameters
    ----------
    p_obs
        Observation table, shape (H, K, L, Z).
    classes, viewpoints
        Names.
    true
        Index of the true class.
    labels
        Names of the Z labels; default: the classes.
    """
    title = f"p(observed | true = {classes[true]}), position 1"
    rows = [
        [name, *(f"{p:.3f}" for p in row)] for name, row in zip(viewpoints, p_obs[0, :, true], strict=True)
    ]
    return _text(title, ["", *(labels or classes)], rows)


def table_two(
    p_obs: Array,
    classes: Sequence[str],
    viewpoints: Sequence[str],
    trues: Sequence[int] | None = None,
    labels: Sequence[str] | None = None,
) -> str:
    """Return the paper's Table II: all positions, the given true classes (default: all), all viewpoints.

    Parameters
    ----------
    p_obs
        Observation table, shape (H, K, L, Z).
    classes, viewpoints
        Names.
    trues
        Indices of the true classes.
    labels
        Names of the Z labels; default: the classes.
    """
    positions = range(len(p_obs))
    header = [
        "true",
        "view",
        *(f"{name} @{position_number(j)}" for j in positions for name in labels or classes),
    ]
    rows = [
        [classes[true], name, *(cell for j in positions for cell in map("{:.3f}".format, p_obs[j, k, true]))]
        for true in (range(len(classes)) if trues is None else trues)
        for k, name in enumerate(viewpoints)
    ]
    return _text("p(observed | true), observed class @ position", header, rows)


def agreement_text(counts: Counts, viewpoints: Sequence[str]) -> str:
    """Return accuracy, agreement of two scans of one object, and missed objects, by table row."""
    rate, error = counts.agreement()
    accuracy, chance, repeat = counts.accuracy(), counts.chance_agreement(), counts.repeat()
    missed = counts.missed.sum(axis=-1)
    rows = [
        [
            position_number(j), name, f"{accuracy[j, k]:.3f}", f"{rate[j, k]:.3f} +- {error[j, k]:.3f}",
            f"{chance[j, k]:.3f}", f"{repeat[j, k]:.3f}", str(missed[j, k]),
        ]
        for j in range(len(rate))
        for k, name in enumerate(viewpoints)
    ]  # fmt: skip
    header = ["position", "view", "accuracy", "two scans agree", "two objects agree", "repeat", "missed"]
    return _text("two scans of one object from one viewpoint", header, rows)


def intervals_text(
    counts: Counts,
    smoothing: float | Array,
    classes: Sequence[str],
    viewpoints: Sequence[str],
    labels: Sequence[str] | None = None,
) -> str:
    """Return the 95 % credible interval of every entry, by position, true class and viewpoint."""
    lower, upper = credible_intervals(counts, smoothing)
    rows = [
        [
            position_number(j), classes[true], name,
            *(f"{a:.3f}-{b:.3f}" for a, b in zip(lower[j, k, true], upper[j, k, true], strict=True)),
        ]
        for j in range(len(lower))
        for true in range(len(classes))
        for k, name in enumerate(viewpoints)
    ]  # fmt: skip
    return _text("95 % credible intervals", ["position", "true", "view", *(labels or classes)], rows)


def independence_text(tests: Sequence[IndependenceTest], viewpoints: Sequence[str]) -> str:
    """Return the tests of independence as a table, a row for each."""
    rows = [
        [
            test.assumption, viewpoints[test.viewpoint],
            ", ".join(position_number(j) for j in test.positions), str(test.scans),
            f"{test.excess:+.3f}", f"{test.p:.4f}",
        ]
        for test in tests
    ]  # fmt: skip
    header = ["assumed independent", "view", "positions", "scans", "excess", "p"]
    return _text("tests of independence given the classes", header, rows)


def _text(title: str, header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    widths = [max(len(line[column]) for line in [header, *rows]) for column in range(len(header))]
    lines = [
        "  ".join(cell.rjust(w) for cell, w in zip(line, widths, strict=True)) for line in [header, *rows]
    ]
    return "\n".join([title, *(line.rstrip() for line in lines)])
