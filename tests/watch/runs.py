"""Runs to watch: simulated bulbs, with the classifier and the tables that come with the package."""

import time
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np

import beltsort
from beltsort.cell import Scan
from beltsort.errors import CloudError
from beltsort.geometry import BeltLayout
from beltsort.perception import Perception
from beltsort.perception.pipeline import Perceived
from beltsort.sim import CellConfig, SimulatedCell
from beltsort.sim.prepare import Recipe, prepare
from beltsort.sorting.heeding import Check, nothing
from beltsort.sorting.report import SortingReport
from beltsort.sorting.rules import Rules
from beltsort.sorting.runs import sort_into, write_true_classes

TRUE = (0, 1, 1, 0, 3, 2)
BINS = ["long", "round", "by hand"]
REWARD = [[10.0, -50.0, -50.0, -50.0], [-50.0, 10.0, 10.0, 10.0], [-5.0, -5.0, -5.0, -5.0]]


class Eyes:
    """The packaged perception; some scans are unusable, and each takes its time."""

    def __init__(self, layout: BeltLayout, unusable: Sequence[int], delay: float) -> None:
        self._perception = Perception(layout, prepare(Recipe()).database)
        self._unusable, self._delay, self._scans = set(unusable), delay, 0

    @property
    def labels(self) -> Sequence[str]:
        return self._perception.labels

    def __call__(self, scan: Scan) -> list[Perceived]:
        time.sleep(self._delay)
        self._scans += 1
        if self._scans in self._unusable:
            raise CloudError("scan has 0 finite points of 307200, expected at least 1: see to the camera")
        return self._perception(scan)


def model_of(positions: int, *, two_bins: bool = False) -> beltsort.SortingModel:
    config = CellConfig()
    names = [viewpoint.name for viewpoint in config.viewpoints]
    model = prepare(Recipe()).counts.model(config.classes, names)
    tables = np.repeat(model.p_obs[:1], positions, axis=0)
    if two_bins:
        return beltsort.SortingModel(model.classes, model.viewpoints, tables, bins=BINS, reward=REWARD)
    return beltsort.SortingModel(model.classes, model.viewpoints, tables)


def sort_bulbs(
    folder: Path,
    *,
    true: Sequence[int | None] = TRUE,
    positions: int = 2,
    two_bins: bool = False,
    unusable: Sequence[int] = (),
    delay: float = 0.0,
    max_looks: int = 60,
    allow_hold: bool = False,
    check: Check = nothing,
) -> SortingReport | None:
    """Sort simulated bulbs in a folder; return None if `check` has ended the run."""
    folder.mkdir(parents=True, exist_ok=True)
    model = model_of(positions, two_bins=two_bins)
    config = CellConfig(layout=BeltLayout(positions=positions))
    cell = SimulatedCell(true, config, seed=1, bin_names=model.bins)
    write_true_classes(folder, 0, true)
    with suppress(KeyboardInterrupt):
        return sort_into(
            folder,
            cell,
            Eyes(config.layout, unusable, delay),
            beltsort.Despot(model, trials=20, scenarios=100),
            model,
            objects=len(true),
            rules=Rules(max_looks=max_looks),
            requests=folder if allow_hold else None,
            check=check,
        )
    return None
