"""Execution of all experiments in order; finished points are stored, so that an interrupted run resumes."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Any

from beltsort.models import simulated
from beltsort.paper.beyond import beyond_points
from beltsort.paper.claims import all_claims
from beltsort.paper.design import Design
from beltsort.paper.labels import label_points, simulate_labels
from beltsort.paper.modes import mode_label_points, mode_scan_points
from beltsort.paper.moving import moving_points, moving_table, sort_moving
from beltsort.paper.optimum import bound_optimum, optimum_points
from beltsort.paper.outcomes import Point, Row, pooled
from beltsort.paper.scans import PreparedCell, scan_points, sort_scans
from beltsort.paper.statistics import ClaimResult
from beltsort.paper.study import Study, papers_study
from beltsort.sim import CellConfig
from beltsort.sim.prepare import Prepared, StageProgress
from beltsort.sweep.engine import run_points

STORE = "points"
Task = Callable[[Mapping[str, Any]], Mapping[str, Any]]


@dataclass(frozen=True, eq=False)
class Results:
    """The rows of all experiments; outcomes have one number per batch.

    Attributes
    ----------
    study
        What was sorted, and what was varied.
    cell
        The simulated cell whose tables and classifier were used; None: of labels from tables only.
    labels, scans, beyond
        Rows of the experiments with labels drawn from tables, of those with depth scans, and of the studies
        that go beyond the paper's.
    moving
        A row per speed and policy on a belt that never stops; see `beltsort.paper.moving.moving_table`.
    optimum
        Bounds of the optimal value and losses of policies; see `bound_optimum`.
    seconds
        Duration of each stage in this run, seconds.
    """

    study: Study
    cell: PreparedCell | None
    labels: list[Row]
    scans: list[Row]
    beyond: list[Row]
    moving: list[Row]
    optimum: list[Row]
    seconds: dict[str, float]

    @property
    def optimum_play(self) -> list[Row]:
        """Rows of batches played with the offline solutions as policies."""
        return [row for solved in self.optimum for row in solved["rows"]]

    @property
    def rows(self) -> list[Row]:
        """All rows of the paper's own experiments, those of the offline solutions included."""
        return [*self.labels, *self.scans, *self.optimum_play]

    def claims(self) -> list[ClaimResult]:
        """Return, for each claim of the paper, whether the results support it."""
        return all_claims(self.rows, self.beyond, self.optimum, self.study.outline, self.moving)


def cell_of(prepared: Prepared, folder: Path) -> PreparedCell:
    """Return the default simulated cell with its trained classifier, which is written to a folder."""
    config = CellConfig()
    names = [viewpoint.name for viewpoint in config.viewpoints]
    note = "simulated cell: says what the simulator was set to"
    model = prepared.counts.model(config.classes, names, note=note)
    return PreparedCell.stored(model, prepared.database, folder, simulated())


def run_experiments(
    cell: PreparedCell | None,
    folder: Path,
    design: Design | Study,
    *,
    seed: int = 0,
    workers: int | None = None,
    stage: StageProgress | None = None,
) -> Results:
    """Run the experiments of a design, except points whose rows are already in the folder.

    The same seed gives the same rows for any number of processes, except for the optimum, whose rows depend
    on the machine's speed. As with `prepare`, a script must call this under `if __name__ == "__main__":`.

    Parameters
    ----------
    cell
        The simulated cell, from `cell_of`; None leaves its tables and depth scans out.
    folder
        Folder in which finished points are stored.
    design
        `FULL`, `QUICK`, or your own, of the paper's study; or another study, from `own_study`.
    seed
        Seed of all experiments.
    workers
        Processes; default one for each core.
    stage
        Called with the name of each stage; returns a function that is called with the number of points done
        and the total number.

    Raises
    ------
    ArgumentError
        If the seed is negative or `workers` is below 1.
    """
    study = design if isinstance(design, Study) else papers_study(design)
    stages = _stages(cell, study, seed)
    rows: dict[str, list[Row]] = {name: [] for name in stages}
    seconds: dict[str, float] = {}
    for name, (task, points) in stages.items():
        began = perf_counter()
        if points:
            progress = None if stage is None else stage(name)
            rows[name] = run_points(task, points, folder / STORE / name, workers=workers, progress=progress)
            seconds[name] = perf_counter() - began
    return Results(
        study,
        cell,
        rows["labels"],
        pooled(rows["scans"]),
        rows["beyond"],
        moving_table(rows["moving"]),
        rows["optimum"],
        seconds,
    )


def _stages(cell: PreparedCell | None, study: Study, seed: int) -> dict[str, tuple[Task, list[Point]]]:
    """Return the task and the points of each stage, by name."""
    design, outline = study.design, study.outline
    labels = label_points(design, seed, [study.instance], outline)
    scans: list[Point] = []
    if cell is not None:
        labels += label_points(design, seed, [cell.instance], outline) + mode_label_points(design, seed, cell)
        scans = scan_points(design, seed, cell) + mode_scan_points(design, seed, cell)
    return {
        "labels": (simulate_labels, labels),
        "scans": (sort_scans, scans),
        "beyond": (simulate_labels, beyond_points(design, seed)),
        "moving": (sort_moving, moving_points(design, seed)),
        "optimum": (bound_optimum, optimum_points(seed, study)),
    }
