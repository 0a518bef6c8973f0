"""A simulated cell whose arm arrives elsewhere, seen through clouds and classifier.

Without noise a scan is a function of object and viewpoint, so that a dropped one leaves no trace.
"""

from pathlib import Path
from typing import Any

import pytest

import beltsort
from beltsort.cell.wrappers.wrapped import WrappedArm, WrappedCamera
from beltsort.cellfile.composed import ComposedCell
from beltsort.perception import Perception
from beltsort.sim import ArmErrors, CellConfig, SimulatedCell
from beltsort.sim.collect import collect_training
from beltsort.sorting.journal import Entry, Journal, read_journal
from beltsort.sorting.loop import sort_objects
from beltsort.sorting.report import SortingReport
from beltsort.testing.fault_kinds import Fault
from beltsort.testing.faults import FaultPlan, Faults
from tests.sim.conftest import PERFECT_SENSOR

CONFIG = CellConfig(noise=PERFECT_SENSOR, arm=ArmErrors(position=0.0, angle=0.0))
TRUE, WRONG, SEED = [2, 0, 1], (2, 5), 11


@pytest.fixture(scope="module")
def perception() -> Perception:
    return Perception(CONFIG.layout, collect_training(CONFIG, objects=1, seed=3, workers=1))


def run(path: Path, perception: Perception, wrong: tuple[int, ...]) -> tuple[SortingReport, list[Entry]]:
    """Return the report of a run and its journal."""
    cell = SimulatedCell(TRUE, CONFIG, seed=SEED)
    faults = Faults(FaultPlan(schedule={("move_to", n): Fault.WRONG_ARRIVAL for n in wrong}), len(cell.poses))
    devices = (WrappedArm(cell, faults), WrappedCamera(cell, faults), cell, cell)
    faulty = ComposedCell(*devices, cell.classes, cell.viewpoints, cell.layout, None, poses=cell.poses)
    table = [[[0.05 + 0.8 * (c == z) for z in range(4)] for c in range(4)]]
    model = beltsort.SortingModel(cell.classes, cell.viewpoints, [table * 3] * 2)
    planner = beltsort.Despot(model, trials=20, scenarios=100)
    with Journal(path) as journal:
        report = sort_objects(faulty, perception, planner, model, journal, objects=len(TRUE))
    return report, read_journal(path)


def data(journal: list[Entry], kind: str) -> list[dict[str, Any]]:
    return [entry.data for entry in journal if entry.kind == kind]


@pytest.mark.slow
def test_decisions_and_beliefs_are_those_of_the_faultless_run(tmp_path: Path, perception: Perception) -> None:
    report, journal = run(tmp_path / "faultless", perception, ())
    watched_report, watched = run(tmp_path / "watched", perception, WRONG)
    assert watched_report == report
    assert data(watched, "scan") == data(journal, "scan")
    assert (len(data(watched, "wrong_viewpoint")), data(journal, "wrong_viewpoint")) == (len(WRONG), [])
