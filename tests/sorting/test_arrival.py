"""An arm that arrives elsewhere and does not notice: the scan tells, and the move is repeated."""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import beltsort
from beltsort.cell import Scan
from beltsort.cell.commands import TIMEOUT
from beltsort.cell.wrappers.wrapped import WrappedArm, WrappedCamera
from beltsort.cellfile.composed import ComposedCell
from beltsort.errors import CellError
from beltsort.sim import CellConfig
from beltsort.sorting.entry_text import EntryFormatter
from beltsort.sorting.journal import Entry, Journal, read_journal
from beltsort.sorting.loop import resume_sorting, sort_objects
from beltsort.sorting.record import progress_in
from beltsort.sorting.report import SortingReport
from beltsort.sorting.rules import Rules
from beltsort.testing.fault_kinds import Fault
from beltsort.testing.faults import FaultPlan, Faults
from tests.sorting.killed_run import perceive
from tests.sorting.scripted_cell import ScriptedCell

POSES = tuple(viewpoint.pose() for viewpoint in CellConfig().viewpoints)
CLASSES = ["nut", "bolt", "screw", "washer"]
SEES = [np.roll(np.eye(4), viewpoint, axis=1) for viewpoint in range(3)]
"""Which label each class gets from each viewpoint: from another one, another."""

MODEL = beltsort.SortingModel(
    CLASSES, ["p1", "p2", "p3"], [[0.96 * sees + 0.01 for sees in SEES]] * 2, r_min=5
)
TRUE = [0, 3, 1, 2, 2, 0, 1, 1]
UNWATCHED = Rules(arrival_angle=180.0, arrival_distance=1e6)


class Camera(ScriptedCell):
    """Arm, camera, belt and sorter; the camera knows its pose and sees what can be seen from there."""

    def scan(self, *, not_before: float, timeout: float = TIMEOUT) -> Scan:
        visible = [*TRUE, 0, 0][self.first : self.first + 2]
        labels = [int(SEES[self.viewpoint][true].argmax()) for true in visible]
        return Scan(np.array([[label, 0.0, 0.0] for label in labels]), POSES[self.viewpoint], not_before)


def composed(camera: Camera, wrong: Sequence[int]) -> ComposedCell:
    """Return the cell, whose moves of these numbers end elsewhere."""
    faults = Faults(FaultPlan(schedule={("move_to", n): Fault.WRONG_ARRIVAL for n in wrong}), len(POSES))
    return ComposedCell(
        *(WrappedArm(camera, faults), WrappedCamera(camera, faults), camera, camera),
        *(tuple(CLASSES), tuple(MODEL.viewpoints), camera.layout, None),
        poses=POSES,
    )


def planner() -> beltsort.Despot:
    return beltsort.Despot(MODEL, trials=20, scenarios=100)


def run(
    folder: Path, wrong: Sequence[int] = (), rules: Rules | None = None, **settings: Any
) -> tuple[SortingReport, list[Entry]]:
    path = folder / "journal.sqlite"
    cell = composed(Camera(MODEL), wrong)
    with Journal(path, **settings) as journal:
        report = sort_objects(cell, perceive, planner(), MODEL, journal, objects=len(TRUE), rules=rules)
    return report, read_journal(path)


def of_kind(entries: Sequence[Entry], kind: str) -> list[dict[str, Any]]:
    return [entry.data for entry in entries if entry.kind == kind]


@pytest.fixture(scope="module")
def faultless(tmp_path_factory: pytest.TempPathFactory) -> SortingReport:
    report, _ = run(tmp_path_factory.mktemp("faultless"))
    assert [decision.label for decision in report.decisions] == TRUE
    return report


WRONG = (2, 4, 6, 8)


@pytest.mark.slow
def test_unnoticed_labels_are_taken_for_those_of_another_viewpoint(tmp_path: Path) -> None:
    report, entries = run(tmp_path, WRONG, UNWATCHED)
    assert of_kind(entries, "wrong_viewpoint") == []
    assert [decision.label for decision in report.decisions] != TRUE


@pytest.mark.slow
def test_noticed_the_run_is_as_if_nothing_had_happened(tmp_path: Path, faultless: SortingReport) -> None:
    report, entries = run(tmp_path, WRONG)
    assert report == faultless, "decisions, beliefs, looks and steps"
    elsewhere = of_kind(entries, "wrong_viewpoint")
    assert len(elsewhere) == len(WRONG)
    assert all(scan["stands_at"] == (scan["viewpoint"] + 1) % 3 for scan in elsewhere)
    assert all(scan["distance"] > 100.0 for scan in elsewhere)
    formatter = EntryFormatter()
    lines = [line for entry in entries if (line := formatter.format(entry)) and "wrong viewpoint" in line]
    assert len(lines) == len(WRONG)
    assert re.search(r"wrong viewpoint\b.*\bp\d\b", lines[0])


@pytest.mark.slow
def test_the_move_is_repeated_once_under_a_new_id_then_the_run_is_held(
    tmp_path: Path, faultless: SortingReport
) -> None:
    with pytest.raises(
        CellError,
        match=r"\bp\d\b.*\bp\d\b.*rules\.arrival_angle.*rules\.arrival_distance.*\b2 times.*`beltsort check`",
    ):
        run(tmp_path, (2, 3))
    path = tmp_path / "journal.sqlite"
    entries = read_journal(path)
    assert of_kind(entries, "state")[-1]["state"] == "Held"
    *_, first, again = of_kind(entries, "intent")
    assert (first["command"]["target"], again["command"]["target"]) == (again["command"]["target"],) * 2
    assert first["command"]["id"] != again["command"]["id"]
    assert [first["command"]["arriving"], again["command"]["arriving"]] == [False, True]
    assert progress_in(path).missed_arrivals == 2
    camera = Camera(MODEL, first=progress_in(path).index)
    with Journal(path, resume=True) as journal:
        assert resume_sorting(composed(camera, [1]), perceive, planner(), journal) == faultless


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["wrong_viewpoint", "intent"])
def test_a_run_killed_before_the_move_is_repeated_goes_on(
    tmp_path: Path, faultless: SortingReport, kind: str
) -> None:
    elsewhere: list[int] = []

    def listener(entry: Entry) -> None:
        elsewhere.extend([entry.number] * (entry.kind == "wrong_viewpoint"))
        if elsewhere and entry.kind == kind:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run(tmp_path, WRONG, listener=listener)
    path = tmp_path / "journal.sqlite"
    camera = Camera(MODEL, first=progress_in(path).index)
    with Journal(path, resume=True) as journal:
        assert resume_sorting(composed(camera, []), perceive, planner(), journal) == faultless


@pytest.mark.slow
def test_a_snapshot_knows_of_it(tmp_path: Path, faultless: SortingReport) -> None:
    report, entries = run(tmp_path, WRONG, largest=8_000)
    assert report == faultless
    assert entries[0].kind == "snapshot"
    assert entries[0].data["strays"] in (0, 1)


def test_small_errors_of_the_arm_are_no_other_viewpoint(tmp_path: Path, faultless: SortingReport) -> None:
    class Trembling(Camera):
        def scan(self, *, not_before: float, timeout: float = TIMEOUT) -> Scan:
            scan, error = super().scan(not_before=not_before), np.eye(4)
            error[0, 3] = 0.04
            return Scan(scan.points, scan.world_from_camera @ error, scan.stamp)

    path = tmp_path / "journal.sqlite"
    with Journal(path) as journal:
        cell = composed(Trembling(MODEL), [])
        assert sort_objects(cell, perceive, planner(), MODEL, journal, objects=len(TRUE)) == faultless


def test_where_the_pose_is_only_assumed_nothing_is_noticed(tmp_path: Path) -> None:
    class Lost(Camera):
        def scan(self, *, not_before: float, timeout: float = TIMEOUT) -> Scan:
            scan = super().scan(not_before=not_before)
            return Scan(scan.points, scan.world_from_camera, scan.stamp, assumed=True)

    with Journal(tmp_path / "journal.sqlite") as journal:
        cell = composed(Lost(MODEL), WRONG)
        sort_objects(cell, perceive, planner(), MODEL, journal, objects=len(TRUE))
    assert of_kind(read_journal(tmp_path / "journal.sqlite"), "wrong_viewpoint") == []
