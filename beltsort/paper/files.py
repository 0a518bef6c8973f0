"""The numbers as CSV files."""

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from beltsort import SortingModel
from beltsort.paper import printed
from beltsort.paper.optimum import losses_table
from beltsort.paper.outcomes import plain_table
from beltsort.paper.run import Results
from beltsort.tables import Counts
from beltsort.tables.intervals import standard_errors

SMOOTHING = 1.0
REPRODUCIBLE = ("tables.csv", "labels.csv", "scans.csv", "beyond.csv", "printed.csv")
"""Files that depend on the seed only; the others depend on how far the offline solutions get."""


def write_tables(results: Results, counts: Counts, folder: Path) -> list[Path]:
    """Write every table into a folder and return the files."""
    tables = {
        "tables.csv": table_entries(results.cell.instance.model, counts),
        "labels.csv": plain_table(results.labels),
        "scans.csv": plain_table(results.scans),
        "beyond.csv": plain_table(results.beyond),
        "printed.csv": printed_numbers(),
        "optimum.csv": losses_table(results.optimum),
        "optimum_play.csv": plain_table(results.optimum_play),
        "findings.csv": [result.plain() for result in results.claims()],
    }
    return [write_csv(folder / name, table) for name, table in tables.items()]


def write_csv(path: Path, table: Sequence[Mapping[str, Any]]) -> Path:
    """Write rows with the same keys; None and NaN become empty cells."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(table[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows({name: _cell(value) for name, value in row.items()} for row in table)
    return path


def _cell(value: Any) -> Any:
    return "" if value is None or value != value else value


def table_entries(model: SortingModel, counts: Counts) -> list[dict[str, Any]]:
    """Return the observation tables (Tables I and II), a row per entry with its standard error."""
    errors = standard_errors(counts, SMOOTHING)
    return [
        {
            "position": j + 1,
            "viewpoint": viewpoint,
            "true": true,
            "observed": observed,
            "probability": float(model.p_obs[j, k, a, b]),
            "standard_error": float(errors[j, k, a, b]),
            "objects": int(counts.counts[j, k, a].sum()),
        }
        for j in range(model.positions)
        for k, viewpoint in enumerate(model.viewpoints)
        for a, true in enumerate(model.classes)
        for b, observed in enumerate(model.labels)
    ]


def printed_numbers() -> list[dict[str, Any]]:
    """Return what the paper prints of its robot."""
    by_penalty = [
        {"positions": None, "r_min": r_min, "positives": printed.POSITIVES[r_min], "steps": steps}
        for r_min, steps in printed.STEPS.items()
    ]
    by_positions = [
        {"positions": positions, "r_min": printed.R_MIN, "positives": None, "steps": steps}
        for positions, steps in printed.STEPS_BY_POSITIONS.items()
    ]
    return [*by_penalty, *by_positions]
