"""What grows in a run of weeks: memory, files and time of a step, for every thousand objects.

``python -m benchmarks.endurance --objects 100000`` sorts with a cell whose labels are drawn from the tables
of the paper's model, with log, metrics, record of calls and journal as in `beltsort run`; ``--scans`` with
the simulated cell and its depth scans, of which there are a few in a second. Most of the time of the first is
that of the disk; ``--folder /dev/shm/run`` does without one.
"""

import argparse
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

import beltsort
from beltsort.cell import Cell, Scan
from beltsort.cell.commands import TIMEOUT, Outcome
from beltsort.cell.protocols import Health
from beltsort.cell.wrappers.recorder import Recorded, Recorder
from beltsort.cell.wrappers.wrapped import WrappedArm, WrappedBelt, WrappedCamera, WrappedSorter
from beltsort.cellfile.composed import ComposedCell
from beltsort.geometry import BeltLayout
from beltsort.monitoring.log_file import LogFile
from beltsort.monitoring.metrics import MetricsServer, RunMetrics
from beltsort.perception import perception_for
from beltsort.sim import CellConfig, SimulatedCell
from beltsort.sim.prepare import Recipe, prepare
from beltsort.sorting.call_log import CallLog, calls_in
from beltsort.sorting.entries import CommandDone, Intended
from beltsort.sorting.journal import Entry
from beltsort.sorting.journal_files import JOURNAL, journal_bytes
from beltsort.sorting.perceived import Perceive
from beltsort.sorting.record import progress_in
from beltsort.sorting.runs import sort_into
from beltsort.util.text import text_table

TRIALS = 20
HEAD = ["objects", "ms a step", "RSS MB", "journal MB", "calls MB", "log MB"]


@dataclass
class TableCell:
    """A cell whose scans are labels drawn from a model's tables."""

    model: beltsort.SortingModel
    seed: int = 0
    viewpoint: int = 0
    object: int = 0
    looks: int = 0

    def health(self) -> Health:
        return Health(ready=True, boot_id="tables")

    def stop(self) -> None:
        pass

    def outcome_of(self, _command_id: str, _boot_id: str = "", /) -> Outcome:
        return Outcome.UNKNOWN

    def position(self) -> int:
        return self.object

    def true_class(self, index: int) -> int:
        return int(np.random.default_rng([self.seed, index]).integers(len(self.model.classes)))

    def move_to(self, viewpoint: int, _command_id: str, *, timeout: float = TIMEOUT) -> float:
        self.viewpoint = viewpoint
        return 0.0

    def scan(self, *, not_before: float, timeout: float = TIMEOUT) -> Scan:
        self.looks += 1
        rng = np.random.default_rng([self.seed, self.object, self.looks])
        labels = [
            rng.choice(
                len(self.model.labels),
                p=self.model.p_obs[j, self.viewpoint, self.true_class(self.object + j)],
            )
            for j in range(self.model.positions)
        ]
        return Scan(np.array([[label, 0.0, 0.0] for label in labels]), np.eye(4), stamp=not_before)

    def sort(self, _label: int, _command_id: str, *, timeout: float = TIMEOUT) -> None:
        pass

    def advance_to(self, index: int, _command_id: str, *, timeout: float = TIMEOUT) -> float:
        self.object, self.looks = index, 0
        return 0.0


@dataclass(frozen=True)
class Label:
    """What is perceived at a position."""

    label: int
    empty: bool = False
    finding: str = "object"


def read_labels(scan: Scan) -> list[Label]:
    return [Label(int(point[0])) for point in scan.points]


def with_tables(record: Callable[[Recorded], None]) -> tuple[Cell, Perceive, beltsort.SortingModel]:
    model = beltsort.models.paper()
    return wrapped(TableCell(model), BeltLayout(positions=model.positions), model, record), read_labels, model


def with_scans(
    objects: int, record: Callable[[Recorded], None]
) -> tuple[Cell, Perceive, beltsort.SortingModel]:
    config = CellConfig()
    prepared = prepare(Recipe(config))
    model = prepared.counts.model(config.classes, [v.name for v in config.viewpoints])
    rng = np.random.default_rng(0)
    device = SimulatedCell([int(c) for c in rng.integers(len(config.classes), size=objects)], config)
    return (
        wrapped(device, config.layout, model, record),
        perception_for(model, config.layout, prepared.database, None),
        model,
    )


def wrapped(
    device: TableCell | SimulatedCell,
    layout: BeltLayout,
    model: beltsort.SortingModel,
    record: Callable[[Recorded], None],
) -> Cell:
    return ComposedCell(
        arm=WrappedArm(device, Recorder("arm", record)),
        camera=WrappedCamera(device, Recorder("camera", record)),
        belt=WrappedBelt(device, Recorder("belt", record)),
        sorter=WrappedSorter(device, Recorder("sorter", record)),
        classes=tuple(model.classes),
        viewpoints=tuple(model.viewpoints),
        layout=layout,
        reject_bin=None,
    )


@dataclass
class Observer:
    """A listener that prints a row for every so many objects."""

    folder: Path
    every: int
    steps: int = 0
    began: float = field(default_factory=time.perf_counter)
    rows: list[list[str]] = field(default_factory=lambda: [HEAD])
    last: int = 0

    def __call__(self, entry: Entry) -> None:
        self.steps += isinstance(entry.content, Intended)
        index = entry.object or 0
        if index >= self.last + self.every and isinstance(entry.content, CommandDone):
            self.row(index)
            self.last, self.steps, self.began = index, 0, time.perf_counter()

    def row(self, index: int) -> None:
        seconds = (time.perf_counter() - self.began) / max(1, self.steps)
        calls = sum(file.stat().st_size for file in calls_in(self.folder))
        log = sum(file.stat().st_size for file in self.folder.glob("run.log*"))
        sizes = [journal_bytes(self.folder), calls, log]
        row = [str(index), f"{1e3 * seconds:.2f}", f"{rss():.1f}", *(f"{size / 1e6:.2f}" for size in sizes)]
        self.rows.append(row)
        print(*(f"{name} {value}" for name, value in zip(HEAD, row, strict=True)), sep="  ", flush=True)


def rss() -> float:
    """Return the resident memory of this process, MB."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * 4096 / 1e6


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--objects", type=int, default=5000)
    parser.add_argument("--every", type=int, default=1000)
    parser.add_argument("--scans", action="store_true", help="the simulated cell, with depth scans")
    parser.add_argument("--folder", type=Path, help="folder of the run (default: a temporary one)")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = given.folder or Path(temporary)
        measure(folder, given.objects, given.every, scans=given.scans)


def measure(folder: Path, objects: int, every: int, *, scans: bool) -> None:
    calls, metrics = CallLog(folder), RunMetrics()
    metrics.folder = folder

    def record(recorded: Recorded) -> None:
        calls(recorded)
        metrics.called(recorded)

    cell, perceive, model = with_scans(objects, record) if scans else with_tables(record)
    planner = beltsort.Despot(model, trials=TRIALS)
    observer = Observer(folder, every)
    with MetricsServer(metrics, 0), LogFile(folder / "run.log", print) as log:
        sort_into(
            *(folder, cell, perceive, planner, model),
            objects=objects,
            listener=[log, metrics, observer],
        )
    began, before = time.perf_counter(), rss()
    progress_in(folder / JOURNAL)
    seconds = time.perf_counter() - began
    print(text_table(observer.rows))
    print(f"reading the journal, as to resume: {seconds:.1f} s, {rss() - before:.0f} MB more")


if __name__ == "__main__":
    main()
