"""`python -m benchmarks.moving_cell`: sorting from depth scans on a belt that never stops.

Simulated belts of bulbs in cups pass an arm with a depth camera; each scan is rendered, segmented, tracked
and labelled. The classifier is trained, and the observation tables are counted, on belts that are only looked
at (`--tables` of each). Then every policy sorts the same belts (`--belts`) at every speed.

Stop-and-go is the same cell with a belt that stands while the camera looks, with classifier and tables of
belts that stand; arm and scans take the same times, an advance takes `ADVANCE` seconds and a decision none.

Results are kept in a CSV file (`--file`), one line per belt, speed and policy; what it contains is not
measured again. At the end the whole file is printed: means and standard errors over belts, and paired
differences from the planner.
"""

import argparse
import csv
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import asdict, fields
from pathlib import Path

import numpy as np

from beltsort import Despot, MovingBelt, MovingPlanner, MovingThreshold
from beltsort.cell.commands import TIMEOUT
from beltsort.perception import Classifier, perception_for
from beltsort.planning.policy import MovingPolicy
from beltsort.sim import SimulatedCell
from beltsort.sim.prepare import prepare
from beltsort.sorting.entries import Planned
from beltsort.sorting.journal import Journal, read_journal
from beltsort.sorting.journal_files import JOURNAL
from beltsort.sorting.loop import sort_objects
from beltsort.sorting.moving.entries import Fate
from benchmarks.moving_cell.cell import CONFIG, OBJECTS, Cell, labels_of, moving_model, run_belt
from benchmarks.moving_cell.estimation import prepared_for_moving
from benchmarks.moving_cell.results import Row, read, table

SPEEDS = (0.045, 0.06, 0.09, 0.12, 0.18)  # metres per second
TRIALS = 10
PLANNER = f"moving-search:{TRIALS}"
THRESHOLDS = (0.8, 0.9, 0.95)
STOPPING = (5.0, 20.0, 50.0)  # r_min of stop-and-go, which trades purity for rate


def policies(moving: MovingBelt, modes: MovingBelt) -> Iterator[tuple[str, MovingPolicy, MovingBelt]]:
    """Yield the policies that are compared, by name, with the belt whose model updates the belief."""
    yield PLANNER, MovingPlanner(modes, trials=TRIALS), modes
    yield f"{PLANNER}, one mode", MovingPlanner(moving, trials=TRIALS), moving
    for threshold in THRESHOLDS:
        yield f"most-urgent:{threshold:g}", MovingThreshold(modes, threshold), modes
    yield "falling-threshold:0.95:0.6", MovingThreshold(modes, 0.95, 0.6), modes
    yield "information-per-tick:0.9", MovingThreshold(modes, 0.9, rule="information-per-tick"), modes


def measured(
    belt: int, speed: float, name: str, policy: MovingPolicy, moving: MovingBelt, classifier: Classifier
) -> Row:
    """Return what one belt came to."""
    with tempfile.TemporaryDirectory() as folder:
        cell = Cell(belt, speed)
        report = run_belt(cell, cell.perception(classifier), policy, moving, Path(folder))
        every = read_journal(Path(folder) / JOURNAL)
    plans = [entry.content.seconds for entry in every if isinstance(entry.content, Planned)]
    right = sum(row[bin] for bin, row in enumerate(report.confusion))
    in_bins = report.fates[Fate.IN_BIN]
    return Row(
        speed, name, belt, report.objects, right, in_bins - right,
        report.objects - in_bins - report.fates[Fate.EMPTY], report.fates[Fate.EMPTY], report.scans,
        OBJECTS * CONFIG.layout.spacing / speed,
        float(np.quantile(plans, 0.99)) if plans else 0.0, float(moving.seconds_per_tick or 0.0),
    )  # fmt: skip


class Standing(SimulatedCell):
    """The cell whose belt stands: a look from where the camera is needs no move, a decision no time."""

    def move_to(self, viewpoint: int, command_id: str, *, timeout: float = TIMEOUT) -> float:
        return self.clock if viewpoint == self._viewpoint else super().move_to(viewpoint, command_id)


def stop_and_go(belt: int, r_min: float) -> Row:
    """Return what one belt came to that stands while the camera looks."""
    config = CONFIG
    prepared = prepare()
    names = [viewpoint.name for viewpoint in config.viewpoints]
    model = prepared.counts.model(config.classes, names, repeats=True, r_min=r_min)
    cell = Standing(labels_of(belt), config, seed=belt)
    perceive = perception_for(model, cell.layout, prepared.database)
    with tempfile.TemporaryDirectory() as folder, Journal(Path(folder) / JOURNAL) as journal:
        policy = Despot(model, trials=TRIALS)
        report = sort_objects(cell, perceive, policy, model, journal, objects=OBJECTS)
    right = sum(decision.label == decision.true_class for decision in report.decisions)
    return Row(
        0.0, f"stop-and-go:{r_min:g}", belt, OBJECTS, right, len(report.decisions) - right, 0,
        len(report.skipped), report.steps, cell.clock, 0.0, 0.0,
    )  # fmt: skip


def rows(
    belts: Sequence[int], speeds: Sequence[float], tables: int, file: Path, known: set[tuple[float, str, int]]
) -> Iterator[Row]:
    """Yield what is not known yet, in order."""
    for belt in belts:
        for r_min in STOPPING:
            if (0.0, f"stop-and-go:{r_min:g}", belt) not in known:
                yield stop_and_go(belt, r_min)
    classifier, plain, modes = prepared_for_moving(tables, file)
    for speed in speeds:
        for name, policy, moving in policies(moving_model(plain, speed), moving_model(modes, speed)):
            for belt in belts:
                if (speed, name, belt) not in known:
                    yield measured(belt, speed, name, policy, moving, classifier)


def main() -> None:
    """Measure what the file lacks, and print all of it."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--belts", type=int, default=5)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--tables", type=int, default=20, help="belts of the survey")
    parser.add_argument("--speeds", type=float, nargs="*", default=SPEEDS)
    parser.add_argument("--file", type=Path, default=Path("moving_cell.csv"))
    given = parser.parse_args()
    known = read(given.file)
    begun = given.file.exists()
    with given.file.open("a", newline="") as lines:
        writer = csv.DictWriter(lines, [field.name for field in fields(Row)])
        if not begun:
            writer.writeheader()
        belts = range(given.first, given.first + given.belts)
        for row in rows(
            belts, given.speeds, given.tables, given.file, {(r.speed, r.policy, r.belt) for r in known}
        ):
            writer.writerow(asdict(row))
            lines.flush()
            known.append(row)
    print("\n".join(table(known, PLANNER)))


if __name__ == "__main__":
    main()
