"""A whole sweep: its points, its rows, its Parquet file."""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import beltsort
from beltsort.errors import SweepError
from beltsort.sim.prepare import StageProgress
from beltsort.sweep.engine import Row, Scheduler, Task, finished_rows, run_points
from beltsort.sweep.file import read_sweep
from beltsort.sweep.grid import points_of
from beltsort.sweep.levels import (
    config_of,
    model_of,
    policy_of,
    prepared_for,
    scan_point,
    table_point,
)
from beltsort.sweep.parquet import load_pyarrow, write_rows
from beltsort.util.processes import Progress

FILE = "rows.parquet"
TASKS: dict[str, Task] = {"tables": table_point, "scans": scan_point}


@dataclass(frozen=True)
class Sweep:
    """A sweep that can be run: every point has a model, a policy and a cell that exist.

    Attributes
    ----------
    task
        What is done at each point.
    points
        The grid, seeds included.
    """

    task: Task
    points: list[dict[str, Any]]

    @classmethod
    def load(cls, path: Path) -> "Sweep":
        """Read a sweep file, and make the cells, models and policies that need no simulation.

        Raises
        ------
        BeltsortError
            If the file cannot be read, or one of them cannot be made.
        """
        load_pyarrow()
        sweep = read_sweep(path)
        points = points_of(sweep, path.resolve().parent)
        _check(points)
        return cls(TASKS[sweep.level], points)

    def prepare(self, progress: StageProgress | None = None) -> None:
        """Train the classifiers and estimate the tables of all cells, where the cache has none yet."""
        if self.task is scan_point:
            for point in _distinct(self.points, "cell."):
                prepared_for(point, progress)

    def run(
        self,
        folder: Path,
        *,
        workers: int | None = None,
        progress: Progress | None = None,
        scheduler: Scheduler | None = None,
    ) -> list[Row]:
        """Run what is missing, and write all rows to the folder's `rows.parquet`.

        The file is written after an error or Ctrl-C, too, with the rows that there are.

        Parameters
        ----------
        folder
            Made if it is missing; keeps the finished rows.
        workers, progress, scheduler
            As in `run_points`.

        Raises
        ------
        SweepError, ArgumentError, BeltsortError
            As `run_points`; also if the file cannot be written.
        """
        try:
            rows = run_points(
                self.task, self.points, folder, workers=workers, progress=progress, scheduler=scheduler
            )
        except BaseException:
            with suppress(beltsort.BeltsortError):  # the first error is the one to report
                if rows := finished_rows(self.task, self.points, folder):
                    write_rows(rows, folder / FILE)
            raise
        write_rows(rows, folder / FILE)
        return rows


def _check(points: list[dict[str, Any]]) -> None:
    """Make every cell, and every model and policy that needs no scans, so that errors come first."""
    for point in _distinct(points, "cell."):
        _make(point, "cell.", lambda point: config_of(point))
    with_model = [point for point in points if "model.file" in point]
    for point in _distinct(with_model, "model."):
        _make(point, "model.", lambda point: model_of(point))
    for point in _distinct(with_model, "planner."):
        _make(point, "planner.", lambda point: policy_of(point, model_of(point), seed=0))


def _distinct(points: list[dict[str, Any]], section: str) -> list[dict[str, Any]]:
    """Return the first point of each combination of a section's values."""
    seen: dict[str, dict[str, Any]] = {}
    for point in points:
        seen.setdefault(repr(_part(point, section)), point)
    return list(seen.values())


def _make(point: dict[str, Any], section: str, make: Callable[[dict[str, Any]], object]) -> None:
    """Make a part of a point; an error names the values of the section that it is made from."""
    try:
        make(point)
    except (beltsort.BeltsortError, TypeError, ValueError, OverflowError) as reason:
        raise SweepError(f"the sweep has {_part(point, section)}: {reason}") from reason


def _part(point: dict[str, Any], section: str) -> dict[str, Any]:
    return {name: value for name, value in point.items() if name.startswith(section)}
