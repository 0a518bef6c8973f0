"""Runs of the simulated cell with faults at random, interrupts, and a truthful person: every object once."""

from pathlib import Path

import numpy as np
import pytest

from beltsort.cell import EmergencyStopError, Scan
from beltsort.cell.commands import TIMEOUT
from beltsort.cell.wrappers.wrapped import WrappedArm, WrappedBelt, WrappedCamera, WrappedSorter
from beltsort.cellfile.composed import ComposedCell
from beltsort.models import paper
from beltsort.sim import CellConfig, SimulatedCell
from beltsort.sorting.holds import Answer, Hold
from beltsort.sorting.journal import Journal
from beltsort.sorting.loop import resume_sorting, sort_objects
from beltsort.sorting.record import progress_in
from beltsort.sorting.report import SortingReport
from beltsort.sorting.rules import Rules
from beltsort.testing.fault_kinds import Fault
from beltsort.testing.faults import FaultPlan, Faults
from tests.sorting.killed_run import perceive
from tests.sorting.scripted_cell import LookOnce

MODEL = paper().replace(p_obs=np.tile(0.01 + 0.96 * np.eye(4), (2, 3, 1, 1)), r_min=5)
OBJECTS, STARTS = 5, 100
RATES = {
    Fault.NOT_DONE: 0.05,
    Fault.LOST_ACKNOWLEDGEMENT: 0.05,
    Fault.LATE: 0.03,
    Fault.FULL_BIN: 0.05,
    Fault.EMERGENCY_STOP: 0.05,
    Fault.RESTART: 0.05,
}
TRUE = [(3 * number + 1) % 4 for number in range(OBJECTS)]


class Seeing(SimulatedCell):
    """Its scans are the true classes: nothing is rendered, nothing mistaken."""

    def scan(self, *, not_before: float, timeout: float = TIMEOUT) -> Scan:
        objects = [self.position() + position for position in range(2)]
        points = [[float(TRUE[number]) if number < OBJECTS else 0.0, 0.0, 0.0] for number in objects]
        return Scan(np.array(points), np.eye(4), stamp=max(not_before, self.clock))


class Run:
    """A run that is begun and resumed until it is done."""

    def __init__(self, folder: Path, seed: int) -> None:
        self.path, self.rng = folder / "journal.sqlite", np.random.default_rng(seed)
        self.world = Seeing(TRUE, CellConfig(), seed=seed)
        faults = Faults(FaultPlan(seed, RATES), len(MODEL.viewpoints))
        self.cell = ComposedCell(
            WrappedArm(self.world, faults),
            WrappedCamera(self.world, faults),
            WrappedBelt(self.world, faults),
            WrappedSorter(self.world, faults),
            *(self.world.classes, self.world.viewpoints, self.world.layout, None),
        )
        self.asked = 0

    def finish(self) -> SortingReport:
        for start in range(STARTS):
            try:
                return self.start(resume=start > 0)
            except (EmergencyStopError, KeyboardInterrupt):
                self.cell.belt.health()  # somebody has released it
        raise AssertionError("the run cannot be resumed")

    def start(self, resume: bool) -> SortingReport:
        rules = Rules(retry_delays=(0.0,) * 8)
        with Journal(self.path, resume=resume) as journal:
            if resume:
                return resume_sorting(
                    *(self.cell, perceive, LookOnce(), journal),
                    rules=rules,
                    operator=self.person,
                    check=self.interrupt,
                )
            return sort_objects(
                *(self.cell, perceive, LookOnce(), MODEL, journal),
                objects=OBJECTS,
                rules=rules,
                operator=self.person,
                check=self.interrupt,
            )

    def interrupt(self) -> None:
        if self.rng.random() < 0.05:
            raise KeyboardInterrupt

    def person(self, hold: Hold) -> Answer | None:
        if not hold.answers:
            return None
        assert hold.answers == (Answer.DONE, Answer.NOT_DONE), hold
        self.asked += 1
        number = progress_in(self.path).index
        return Answer.DONE if number in dict(self.world.bins) else Answer.NOT_DONE


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(50))
def test_every_object_is_sorted_once(seed: int, tmp_path: Path) -> None:
    run = Run(tmp_path, seed)
    report = run.finish()
    assert [(decision.object, decision.label) for decision in report.decisions] == list(enumerate(TRUE))
    assert run.world.bins == list(enumerate(TRUE))
    assert report.passed == ()
