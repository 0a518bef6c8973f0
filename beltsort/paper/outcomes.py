"""Points (what is simulated) and rows (their results, with one number per batch)."""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from beltsort import ArgumentError
from beltsort.paper.statistics import Estimate, mean

Point = dict[str, Any]
"""Plain JSON data with everything that a task needs."""

Row = dict[str, Any]
"""A point's condition (`CONDITION`), and lists with one number per batch (`OUTCOMES`)."""

STUDY = "paper"
"""The column `study` of the paper's own experiments."""

LABELS, SCANS = "labels from tables", "depth scans"
"""The column `level`: where labels come from."""

CONDITION = (
    *("study", "setting", "level", "instance", "objects"),
    *("positions", "discount", "r_min", "policy", "parameter"),
)
OUTCOMES = ("steps", "positives", "negatives", "returns")


def condition(row: Mapping[str, Any]) -> Row:
    """Return the condition of a row, or of a point whose policy has no parameter."""
    return {name: row.get(name) if name == "parameter" else row[name] for name in CONDITION}


def select(rows: Iterable[Row], **wanted: Any) -> list[Row]:
    """Return the rows of a condition, by r_min.

    Examples
    --------
    >>> rows = [{"r_min": 50, "positions": 1}, {"r_min": 5, "positions": 1}, {"r_min": 5, "positions": 2}]
    >>> select(rows, positions=1)
    [{'r_min': 5, 'positions': 1}, {'r_min': 50, 'positions': 1}]
    """
    found = [row for row in rows if all(row[name] == value for name, value in wanted.items())]
    return sorted(found, key=lambda row: float(row["r_min"]))


def only(rows: Iterable[Row], **wanted: Any) -> Row:
    """Return the one row of a condition.

    Raises
    ------
    ArgumentError
        If there is none, or more than one.
    """
    found = select(rows, **wanted)
    if len(found) != 1:
        raise ArgumentError(f"{len(found)} rows with {wanted}, expected one; say all of the condition")
    return found[0]


def estimates(row: Row) -> dict[str, Estimate]:
    """Return the mean of each outcome of a row."""
    return {name: mean(row[name]) for name in OUTCOMES}


def estimate_in(row: Row, outcome: str) -> Estimate:
    """Return the estimate of an outcome in a row of a plain table; NaN where the cell is empty.

    Examples
    --------
    >>> estimate_in({"steps": 40.0, "steps_standard_error": 0.5, "batches": 100}, "steps")
    Estimate(value=40.0, standard_error=0.5, n=100)
    """
    value = row[outcome]
    error = row[f"{outcome}_standard_error"]
    return Estimate(math.nan if value is None else value, error, row["batches"])


def pooled(rows: Sequence[Row]) -> list[Row]:
    """Join rows of one condition whose batches were run one by one; the order is that of the first rows."""
    together: dict[tuple[Any, ...], Row] = {}
    for row in rows:
        joined = together.setdefault(
            tuple(row[name] for name in CONDITION), {**condition(row), **{name: [] for name in OUTCOMES}}
        )
        for name in OUTCOMES:
            joined[name] = [*joined[name], *row[name]]
    return list(together.values())


def plain_table(rows: Iterable[Row]) -> list[dict[str, Any]]:
    """Return rows with means and standard errors in place of single batches, as for the CSV files."""
    return [
        {
            **condition(row),
            "batches": len(row["steps"]),
            **{
                column: value
                for name, estimate in estimates(row).items()
                for column, value in (
                    (name, estimate.value),
                    (f"{name}_standard_error", estimate.standard_error),
                )
            },
        }
        for row in rows
    ]
