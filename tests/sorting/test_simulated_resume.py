"""A simulated cell that is brought back after its process ended."""

from pathlib import Path

import numpy as np
import pytest

import beltsort
from beltsort.cell import Scan
from beltsort.cellfile.run import restore
from beltsort.sim import CellConfig, SimulatedCell
from beltsort.sorting.journal import Entry, Journal
from beltsort.sorting.loop import resume_sorting, sort_objects
from beltsort.sorting.record import progress_in
from beltsort.sorting.report import SortingReport
from tests.sorting.scripted_cell import Glimpsed

TRUE = [0, 1, 2]
MODEL = beltsort.SortingModel.load("tests/fixtures/paper.json").replace(r_min=5)


def perceive(scan: Scan) -> list[Glimpsed]:
    """Labels that depend on every digit of every point."""
    depths = scan.points[..., 2]
    numbers = (np.nansum(depths[:, :320]), np.nansum(depths[:, 320:]))
    return [Glimpsed(label=int(number * 1e6) % 4, empty=False) for number in numbers]


def run(folder: Path, interrupt_at: int | None = None, *, resume: bool = False) -> SortingReport:
    def listener(entry: Entry) -> None:
        if entry.number == interrupt_at:
            raise KeyboardInterrupt

    path = folder / "journal.sqlite"
    planner = beltsort.Despot(MODEL, trials=20, scenarios=100)
    cell = SimulatedCell(TRUE, CellConfig(), seed=3)
    if not resume:
        with Journal(path, listener) as journal:
            return sort_objects(cell, perceive, planner, MODEL, journal, objects=len(TRUE))
    progress = progress_in(path)
    restore([cell], progress)
    with Journal(path, resume=True) as journal:
        return resume_sorting(cell, perceive, planner, journal)


@pytest.fixture(scope="module")
def uninterrupted(tmp_path_factory: pytest.TempPathFactory) -> SortingReport:
    return run(tmp_path_factory.mktemp("whole"))


@pytest.mark.slow
@pytest.mark.parametrize("entry", [4, 8, 13, 21, 26])
def test_the_same_scans_and_decisions(tmp_path: Path, entry: int, uninterrupted: SortingReport) -> None:
    with pytest.raises(KeyboardInterrupt):
        run(tmp_path, interrupt_at=entry)
    assert run(tmp_path, resume=True) == uninterrupted
