"""Experiments on depth scans: the simulated cell, perception and the loop, ten bulbs a batch.

They take much longer than labels from tables, and are run with the recommended planner only.
"""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from beltsort import Despot, SortingModel
from beltsort.paper.design import Design, Stream, seed_of
from beltsort.paper.instances import OBJECTS, Instance
from beltsort.paper.outcomes import SCANS, STUDY, Point, Row
from beltsort.paper.policies import BATCH, RECOMMENDED
from beltsort.perception import NearestNeighbour, perception_for
from beltsort.sim import CellConfig, SimulatedCell
from beltsort.sorting.journal import Journal
from beltsort.sorting.loop import sort_objects
from beltsort.sorting.report import SortingReport


@dataclass(frozen=True)
class PreparedCell:
    """Tables and classifier of a simulated cell; the classifier is on disk for other processes to read.

    Attributes
    ----------
    instance
        The tables.
    database
        The classifier's file; its name contains a hash of its content.
    modes
        Tables of the same cell with modes, for labels with confidence levels; None: these are left out.
    """

    instance: Instance
    database: Path
    modes: Instance | None = None

    @classmethod
    def stored(
        cls,
        model: SortingModel,
        database: NearestNeighbour,
        folder: Path,
        modes: SortingModel | None = None,
    ) -> "PreparedCell":
        """Write the classifier into a folder."""
        folder.mkdir(parents=True, exist_ok=True)
        content = hashlib.sha256(database.descriptors.tobytes() + np.asarray(database.labels).tobytes())
        path = folder.resolve() / f"classifier-{content.hexdigest()[:16]}.npz"
        if not path.exists():
            half_done = path.with_name(f"half-done-{path.name}")
            database.save(half_done)
            half_done.replace(path)
        return cls(Instance("cell", model), path, None if modes is None else Instance("cell_modes", modes))

    @property
    def with_modes(self) -> "PreparedCell | None":
        """The cell with the tables with modes in place of the others, or None."""
        return None if self.modes is None else replace(self, instance=self.modes)


def scan_points(
    design: Design, seed: int, cell: PreparedCell, r_mins: Sequence[float] | None = None
) -> list[Point]:
    """Return a point per batch: one and two positions, both sets of objects, all penalties or some."""
    return [
        scan_point(design, seed, cell, positions, r_min, batch)
        | {"objects": objects.name, "classes": list(objects.classes)}
        for objects in OBJECTS
        for positions in (1, 2)
        for r_min in (design.r_min_scans if r_mins is None else r_mins)
        for batch in range(design.batches_scans)
    ]


def scan_point(
    design: Design, seed: int, cell: PreparedCell, positions: int, r_min: float, batch: int
) -> Point:
    """Return the point of one batch of the two classes that the paper draws from."""
    model = cell.instance.model.with_positions(positions)
    return {
        "study": STUDY,
        "setting": None,
        "level": SCANS,
        "instance": cell.instance.name,
        "objects": OBJECTS[0].name,
        "classes": list(OBJECTS[0].classes),
        "positions": positions,
        "discount": design.discounts[0],
        "r_min": r_min,
        "model": model.replace(r_min=r_min, discount=design.discounts[0]).to_json(),
        "policy": RECOMMENDED,
        "trials": design.trials,
        "database": str(cell.database),
        "batch": batch,
        "seed": seed_of(seed, Stream.SCANS, batch),
    }


def sort_scans(point: Mapping[str, Any]) -> Row:
    """Run a point; with the point's own keys, what is returned is a row with one batch.

    Objects and noise are the same for every r_min and number of positions.
    """
    with TemporaryDirectory() as folder:
        return sort_batch(point, Path(folder) / "journal.sqlite")


def sort_batch(point: Mapping[str, Any], journal: Path) -> Row:
    """Run a point and keep its journal."""
    model = SortingModel.from_json(point["model"])
    true = true_labels(point, model)
    cell = SimulatedCell(true, cell_with(model.positions), seed=point["seed"])
    perception = perception_for(model, cell.layout, _classifier(point["database"]))
    planner = _planner(point["model"], point["trials"])
    with Journal(journal) as written:
        report = sort_objects(cell, perception, planner, model, written, objects=BATCH)
    return outcomes_of(report, true, model)


def true_labels(point: Mapping[str, Any], model: SortingModel) -> list[int]:
    """Draw the objects of a batch, and those that stand behind the last one."""
    indices = [model.classes.index(name) for name in point["classes"]]
    drawn = np.random.default_rng(seed_of(point["seed"], Stream.TRUE_CLASSES)).choice(indices, size=2 * BATCH)
    return [int(label) for label in drawn[: BATCH + model.positions - 1]]


def cell_with(positions: int) -> CellConfig:
    """Return the default cell with only the first positions of its belt observed."""
    default = CellConfig()
    unseen = default.layout.positions - positions
    return replace(
        default, layout=replace(default.layout, positions=positions), upstream=default.upstream + unseen
    )


def outcomes_of(report: SortingReport, true: list[int], model: SortingModel) -> Row:
    """Return the outcomes of one batch; an object taken for an empty cup is neither right nor wrong."""
    right = [decision.label == true[decision.object] for decision in report.decisions]
    rewards = sum(model.r_max if hit else -model.r_min for hit in right)
    return {
        "parameter": None,
        "steps": [report.steps],
        "positives": [sum(right)],
        "negatives": [len(right) - sum(right)],
        "returns": [rewards - (report.steps - len(right))],
    }


@lru_cache(maxsize=1)
def _planner(model: str, trials: int) -> Despot:
    """Make a planner once for the batches of one condition; plans do not depend on earlier ones."""
    return Despot(SortingModel.from_json(model), trials=trials, threads=1)


@lru_cache(maxsize=1)
def _classifier(path: str) -> NearestNeighbour:
    """Read a classifier once per process."""
    return NearestNeighbour.load(path)
