"""The numbers of a reproduction as files, from which its figures and report can be drawn again."""

import csv
import json
import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from beltsort import ArgumentError, SortingModel
from beltsort.paper import printed
from beltsort.paper.circumstances import Circumstances
from beltsort.paper.optimum import losses_table
from beltsort.paper.outcomes import Row, plain_table
from beltsort.paper.run import Results
from beltsort.paper.statistics import ClaimResult
from beltsort.tables import Counts
from beltsort.tables.intervals import standard_errors

SMOOTHING = 1.0
REPRODUCIBLE = ("tables.csv", "labels.csv", "scans.csv", "beyond.csv", "printed.csv")
"""Files that depend on the seed only; the others depend on how far the offline solutions get."""

CIRCUMSTANCES = "circumstances.json"


@dataclass(frozen=True, eq=False)
class Numbers:
    """What figures and report show: means and standard errors, as they stand in the CSV files.

    Attributes
    ----------
    tables
        Entries of the simulated cell's observation tables; see `table_entries`.
    labels, scans, beyond, optimum_play
        From `beltsort.paper.outcomes.plain_table`.
    optimum
        From `beltsort.paper.optimum.losses_table`.
    findings
        Whether each claim holds.
    circumstances
        How they were made.
    """

    tables: list[Row]
    labels: list[Row]
    scans: list[Row]
    beyond: list[Row]
    optimum: list[Row]
    optimum_play: list[Row]
    findings: list[ClaimResult]
    circumstances: Circumstances

    @classmethod
    def of(cls, results: Results, counts: Counts, circumstances: Circumstances) -> "Numbers":
        """Return those of results."""
        return cls(
            table_entries(results.cell.instance.model, counts),
            plain_table(results.labels),
            plain_table(results.scans),
            plain_table(results.beyond),
            losses_table(results.optimum),
            plain_table(results.optimum_play),
            results.claims(),
            circumstances,
        )

    @classmethod
    def read(cls, folder: Path) -> "Numbers":
        """Return those that `write` has written into a folder.

        Raises
        ------
        ArgumentError
            If a file is missing or is not of this kind.
        """
        try:
            about = Circumstances.from_plain(json.loads((folder / CIRCUMSTANCES).read_text(encoding="utf-8")))
            findings = [ClaimResult.from_plain(row) for row in _read_csv(folder / "findings.csv")]
            rows = {name: [_typed(row) for row in _read_csv(folder / f"{name}.csv")] for name in cls._rows()}
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise ArgumentError(
                f"{folder} cannot be read ({type(error).__name__}: {error}), expected a folder that "
                "`beltsort reproduce` has written: give such a folder"
            ) from error
        return cls(**rows, findings=findings, circumstances=about)

    def write(self, folder: Path) -> list[Path]:
        """Write every table, and the circumstances, into a folder; return the CSV files."""
        text = json.dumps(asdict(self.circumstances), indent=2)
        (folder / CIRCUMSTANCES).write_text(text + "\n", encoding="utf-8")
        found = {name: getattr(self, name) for name in self._rows()}
        found |= {"printed": printed_numbers(), "findings": [result.plain() for result in self.findings]}
        return [write_csv(folder / f"{name}.csv", table) for name, table in found.items()]

    @staticmethod
    def _rows() -> tuple[str, ...]:
        return ("tables", "labels", "scans", "beyond", "optimum", "optimum_play")

    @property
    def rows(self) -> list[Row]:
        """All rows of the paper's own experiments, those of the offline solutions included."""
        return [*self.labels, *self.scans, *self.optimum_play]


def write_csv(path: Path, table: Sequence[Mapping[str, Any]]) -> Path:
    """Write rows with the same keys; None and NaN become empty cells."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(table[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows({name: _cell(value) for name, value in row.items()} for row in table)
    return path


def _cell(value: Any) -> Any:
    return "" if value is None or value != value else value


def _read_csv(path: Path) -> list[dict[str, str]]:
    with path.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    if not rows:
        raise ValueError(f"{path.name} is empty")
    return rows


def _typed(row: Mapping[str, str]) -> Row:
    """Return a row with numbers as numbers; an empty cell is None, or NaN if it is of a standard error."""
    return {name: _value(name, text) for name, text in row.items()}


def _value(name: str, text: str) -> str | float | int | None:
    if not text:
        return math.nan if name.endswith("_standard_error") else None
    for number in (int, float):
        with suppress(ValueError):
            return number(text)
    return text


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
