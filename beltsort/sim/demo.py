"""The demonstration: ten bulbs sorted from depth scans of the simulated cell."""

import json
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

import beltsort
from beltsort.perception import Perception
from beltsort.planning.decisions import right_bins
from beltsort.rrd import Recorder
from beltsort.sim import CellConfig, SimulatedCell
from beltsort.sim.prepare import Prepared
from beltsort.sorting.belief_figure import draw_belief
from beltsort.sorting.journal import Listener, read_journal
from beltsort.sorting.journal_files import JOURNAL
from beltsort.sorting.report import SortingReport, confusion
from beltsort.sorting.runs import plain_decision, sort_into, write_true_classes

OBJECTS = 10
DRAWN_FROM = ("elongated", "livarno")
TRIALS = 300


@dataclass(frozen=True, eq=False)
class DemoResult:
    """Results of a demonstration.

    Attributes
    ----------
    true_labels
        Class index of each object.
    report
        Steps and decisions.
    model
        The planner's model.
    seconds
        Duration of each stage, seconds.
    folder
        Folder of journal, model and figure.
    """

    true_labels: tuple[int, ...]
    report: SortingReport
    model: beltsort.SortingModel
    seconds: dict[str, float]
    folder: Path

    @property
    def correct(self) -> int:
        """Number of correct decisions."""
        return int(self.confusion[right_bins(self.model)].sum())

    @property
    def confusion(self) -> NDArray[np.uint64]:
        """Number of objects by bin and true class, shape (B, L)."""
        decisions = ((d.object, d.label) for d in self.report.decisions)
        return confusion(decisions, self.true_labels.__getitem__, self.model)


def true_labels(seed: int, classes: tuple[str, ...]) -> tuple[int, ...]:
    """Draw the objects of a run: `OBJECTS` class indices, uniformly from `DRAWN_FROM` as in the paper."""
    rng = np.random.default_rng(seed)
    return tuple(classes.index(DRAWN_FROM[i]) for i in rng.integers(len(DRAWN_FROM), size=OBJECTS))


def check_seed(seed: int) -> None:
    """Check a seed.

    Raises
    ------
    ArgumentError
        If the seed is negative.
    """
    if seed < 0:
        raise beltsort.ArgumentError(f"seed is {seed}, expected an integer of at least 0; choose another")


def run_demo(
    prepared: Prepared,
    seed: int,
    folder: Path,
    listener: Listener | None = None,
    *,
    rrd: Path | None = None,
    say: Callable[[str], None] = print,
) -> DemoResult:
    """Sort ten bulbs of the simulated cell, planning with DESPOT.

    Labels, actions and decisions are reproducible from the seed.

    Parameters
    ----------
    prepared
        Classifier and tables of the default simulated cell.
    seed
        Seed of the objects, the cell and the planner.
    folder
        An existing folder for journal, model and figure.
    listener
        Called with every journal entry.
    rrd
        File of a recording for the rerun viewer; None: there is none.
    say
        Called with a line if the recording fails.

    Raises
    ------
    ArgumentError
        If the seed is negative.
    RecordingError
        If the recording cannot be begun.
    """
    check_seed(seed)
    config = CellConfig()
    began = perf_counter()
    names = [viewpoint.name for viewpoint in config.viewpoints]
    model = prepared.counts.model(
        config.classes, names, note="simulated cell: says what the simulator was set to"
    )
    planner = beltsort.Despot(model, seed=seed, trials=TRIALS)
    ready = perf_counter()
    labels = true_labels(seed, config.classes)
    cell = SimulatedCell(labels, config, seed=seed)
    perception = Perception(config.layout, prepared.database)
    write_true_classes(folder, 0, labels)
    recorder = None if rrd is None else Recorder(rrd, cell, model, say, cell.true_class)
    with recorder or nullcontext():
        report = sort_into(
            folder,
            cell,
            perception,
            planner,
            model,
            objects=OBJECTS,
            listener=(recorder, listener),
            scan_listener=None if recorder is None else recorder.scanned,
        )
    sorted_at = perf_counter()
    true = [config.classes[label] for label in labels]
    draw_belief(read_journal(folder / JOURNAL), folder / "belief.png", true)
    seconds = {
        **prepared.seconds,
        "planner": ready - began,
        "sorting": sorted_at - ready,
        "picture": perf_counter() - sorted_at,
    }
    return DemoResult(labels, report, model, seconds, folder)


def as_json(result: DemoResult, seed: int) -> dict[str, Any]:
    """Return the results as plain data."""
    classes = result.model.classes
    decisions = [
        {"true": classes[result.true_labels[d.object]], **plain_decision(d, result.model.bins)}
        for d in result.report.decisions
    ]
    return {
        "steps": result.report.steps,
        "correct": result.correct,
        "confusion": result.confusion.tolist(),
        "decisions": decisions,
        "model": json.loads(result.model.to_json()),
        "seconds": {name: round(value, 3) for name, value in result.seconds.items()},
        "seed": seed,
        "folder": str(result.folder),
    }
