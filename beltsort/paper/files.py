"""The numbers of a reproduction as files, from which its figures and report can be drawn again."""

import csv
import json
import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from beltsort import ArgumentError, SortingModel
from beltsort.paper import printed
from beltsort.paper.circumstances import Circumstances
from beltsort.paper.optimum import losses_table
from beltsort.paper.outcomes import Row, plain_table
from beltsort.paper.outline import Outline
from beltsort.paper.run import Results
from beltsort.paper.statistics import ClaimResult
from beltsort.tables import Counts
from beltsort.tables.intervals import standard_errors

SMOOTHING = 1.0
REPRODUCIBLE = ("tables.csv", "labels.csv", "scans.csv", "beyond.csv", "moving.csv", "printed.csv")
"""Files that depend on the seed only; the others depend on how far the offline solutions get."""

CIRCUMSTANCES = "circumstances.json"


@dataclass(frozen=True, eq=False)
class Numbers:
    """What figures and report show: means and standard errors, as they stand in the CSV files.

    Attributes
    ----------
    tables
        Entries of the observation tables, of the simulated cell's in the paper's study; see `table_entries`.
    labels, scans, beyond, optimum_play
        From `beltsort.paper.outcomes.plain_table`.
    moving
        From `beltsort.paper.moving.moving_table`.
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
    moving: list[Row]
    optimum: list[Row]
    optimum_play: list[Row]
    findings: list[ClaimResult]
    circumstances: Circumstances

    @classmethod
    def of(cls, results: Results, counts: Counts | None, circumstances: Circumstances) -> "Numbers":
        """Return those of results; `counts` are those of the simulated cell."""
        instance = results.study.instance if results.cell is None else results.cell.instance
        return cls(
            table_entries(instance.model, counts),
            plain_table(results.labels),
            plain_table(results.scans),
            plain_table(results.beyond),
            results.moving,
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
            about = _circumstances_in(folder)
            findings = [ClaimResult.from_plain(row) for row in _read_csv(folder / "findings.csv")]
            needed = set(cls._rows()) - (set() if about.design.speeds else {"moving"})
            rows = {
                name: [_typed(row) for row in _read_csv(folder / f"{name}.csv")]
                for name in cls._rows()
                if (about.outline.of_the_paper and name in needed) or (folder / f"{name}.csv").exists()
            }
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise _unreadable(folder, error) from error
        return cls(**({name: [] for name in cls._rows()} | rows), findings=findings, circumstances=about)

    def write(self, folder: Path) -> list[Path]:
        """Write every table that has rows, and the circumstances, into a folder; return the CSV files."""
        text = json.dumps(asdict(self.circumstances), indent=2)
        (folder / CIRCUMSTANCES).write_text(text + "\n", encoding="utf-8")
        found = {name: getattr(self, name) for name in self._rows()}
        found["printed"] = printed_numbers() if self.circumstances.outline.of_the_paper else []
        found["findings"] = [result.plain() for result in self.findings]
        for name, table in found.items():
            if not table:  # of an earlier study in the same folder
                (folder / f"{name}.csv").unlink(missing_ok=True)
        return [write_csv(folder / f"{name}.csv", table) for name, table in found.items() if table]

    @staticmethod
    def _rows() -> tuple[str, ...]:
        return ("tables", "labels", "scans", "beyond", "moving", "optimum", "optimum_play")

    @property
    def rows(self) -> list[Row]:
        """All rows of the paper's own experiments, those of the offline solutions included."""
        return [*self.labels, *self.scans, *self.optimum_play]


def outline_in(folder: Path) -> Outline:
    """Return what was varied in a reproduction.

    Raises
    ------
    ArgumentError
        If the folder has no reproduction.
    """
    try:
        return _circumstances_in(folder).outline
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise _unreadable(folder, error) from error


def _circumstances_in(folder: Path) -> Circumstances:
    return Circumstances.from_plain(json.loads((folder / CIRCUMSTANCES).read_text(encoding="utf-8")))


def _unreadable(folder: Path, error: Exception) -> ArgumentError:
    return ArgumentError(
        f"{folder} cannot be read ({type(error).__name__}: {error}), expected a folder that "
        "`beltsort reproduce` has written: give such a folder"
    )


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
        return math.nan if name.endswith("standard_error") else None
    for number in (int, float):
        with suppress(ValueError):
            return number(text)
    return text


def table_entries(model: SortingModel, counts: Counts | None) -> list[dict[str, Any]]:
    """Return the observation tables (Tables I and II), a row per entry with its standard error.

    Parameters
    ----------
    model
        The tables; those of a class with modes have a row for each of its modes.
    counts
        What they were estimated from; default: the counts in the model, if there are any.
    """
    seen = model.counts if counts is None else counts.counts
    errors = _model_errors(model) if counts is None else standard_errors(counts, SMOOTHING)
    return [
        {
            "position": j + 1,
            "viewpoint": viewpoint,
            "true": true,
            "observed": observed,
            "probability": float(model.p_obs[j, k, a, b]),
            "standard_error": float(errors[j, k, a, b]),
            "objects": None if seen is None else int(seen[j, k, a].sum()),
        }
        for j in range(model.positions)
        for k, viewpoint in enumerate(model.viewpoints)
        for a, true in enumerate(_kinds(model))
        for b, observed in enumerate(model.labels)
    ]


def _model_errors(model: SortingModel) -> NDArray[np.float64]:
    """Return the standard errors of a model's tables, shape (H, K, N, Z); NaN if it has no counts."""
    if model.counts is None:
        return np.full(model.p_obs.shape, math.nan)
    pseudo = 0.0 if model.smoothing is None else np.asarray(model.smoothing)
    weight = (model.counts + pseudo).sum(axis=-1, keepdims=True)
    errors: NDArray[np.float64] = np.sqrt(model.p_obs * (1.0 - model.p_obs) / (weight + 1.0))
    return errors


def _kinds(model: SortingModel) -> list[str]:
    """Return the names of the N kinds: classes, with the number of the mode where there are several."""
    return [
        name if len(weights) == 1 else f"{name}, mode {mode}"
        for name, weights in zip(model.classes, model.modes, strict=True)
        for mode in range(1, len(weights) + 1)
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
