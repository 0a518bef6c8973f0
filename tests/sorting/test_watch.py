"""The watch over the tables in the loop: a function of its journal; it holds the run if asked to."""

import itertools
import json
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from beltsort import Belief, Decide, Move, SortingModel, Threshold
from beltsort.cell import Scan
from beltsort.cell.commands import TIMEOUT
from beltsort.errors import CellError
from beltsort.sorting.audit import incidents_of, steps_of
from beltsort.sorting.entry_text import EntryFormatter
from beltsort.sorting.journal import Entry, Journal, read_journal
from beltsort.sorting.loop import resume_sorting, sort_objects
from beltsort.sorting.progress import Progress
from beltsort.sorting.record import progress_in
from beltsort.sorting.report import SortingReport
from beltsort.sorting.rules import Drift
from beltsort.tables import DriftWatch
from tests.sorting.killed_run import perceive
from tests.sorting.scripted_cell import Glimpse, ScriptedCell, scripted

PAPER = SortingModel.load("tests/fixtures/paper.json")
SMOOTH = SortingModel(PAPER.classes, PAPER.viewpoints, (50 * PAPER.p_obs + 1) / (50 + 4))
WATCHED = Drift(false_alarm=0.05)


class LookTwiceAndDecide:
    """Looks at every object from the first viewpoint, twice."""

    def __init__(self) -> None:
        self.looks = 0

    def act(self, belief: Belief, viewpoint: int) -> Move | Decide:
        self.looks = (self.looks + 1) % 3
        return Move(0) if self.looks else Decide(belief.most_likely(0)[0])


def scripted_run(
    tmp_path: Path, model: SortingModel, scans: Sequence[Sequence[Glimpse]], drift: Drift | None = WATCHED
) -> list[Entry]:
    path = tmp_path / "journal.sqlite"
    with Journal(path) as journal:
        sort_objects(
            *(ScriptedCell(model), scripted(itertools.cycle(scans)), LookTwiceAndDecide(), model, journal),
            objects=20,
            drift=drift,
        )
    return read_journal(path)


def drifts(entries: Sequence[Entry]) -> list[Entry]:
    return [entry for entry in entries if entry.kind == "drift"]


def lines(entries: list[Entry]) -> list[str]:
    formatter = EntryFormatter()
    return [line for entry in entries if (line := formatter.format(entry))]


def test_an_alarm_is_journalled_after_its_scan_and_told(tmp_path: Path) -> None:
    table = [[[[0.95, 0.05], [0.05, 0.95]]]] * 2
    model = SortingModel(["nut", "bolt"], ["above"], table)
    entries = scripted_run(tmp_path, model, [[0, 0], [1, 1]])
    watch = Progress.after(entries).drift.watch
    assert watch is not None
    assert [entry.data for entry in drifts(entries)] == [alarm.to_dict() for alarm in watch.alarms]
    assert entries[entries.index(drifts(entries)[0]) - 1].kind == "scan"
    assert entries[-1].data == {"reason": "done"}
    warnings = [line for line in lines(entries) if re.search(r"\blabels\b.*\btables\b", line)]
    assert len(warnings) == len(watch.alarms) > 0
    assert any("position 1 from above" in line for line in warnings)
    assert any("warning: labels" in line for line in warnings)


def test_labels_as_the_tables_say_raise_no_alarm(tmp_path: Path) -> None:
    scans = [[n // 2 % 4, (n // 2 + 1) % 4] for n in range(8)]
    entries = scripted_run(tmp_path, PAPER, scans)
    watch = Progress.after(entries).drift.watch
    assert drifts(entries) == []
    assert watch is not None
    mean, _ = watch.surprise()
    assert mean[0, 0] < 0.0


def test_an_impossible_label_is_journalled_too(tmp_path: Path) -> None:
    model = SortingModel(PAPER.classes, PAPER.viewpoints, PAPER.p_obs, arrival=[1.0, 0.0, 0.0, 0.0])
    entries = scripted_run(tmp_path, model, [[2, None]])
    assert [entry.data["evidence"] for entry in drifts(entries)] == [None, None]


def test_nobody_watches_unless_asked_to(tmp_path: Path) -> None:
    entries = scripted_run(tmp_path, SMOOTH, [[0, 0], [1, 1]], drift=None)
    assert drifts(entries) == []
    assert Progress.after(entries).drift.watch is None


CHANGE, OBJECTS, SEED = 8, 60, 4
NEVER = OBJECTS + 2


class Drifting(ScriptedCell):
    """Draws labels by (seed, object at the belt end, scan there); from object `change` on by other tables."""

    def __init__(self, first: int = 0, scans: int = 0, change: int = CHANGE) -> None:
        super().__init__(SMOOTH, first=first)
        self.scans, self.change = scans, change

    def advance_to(self, index: int, command_id: str, *, timeout: float = TIMEOUT) -> float:
        self.scans = 0 if index != self.first else self.scans
        return super().advance_to(index, command_id)

    def scan(self, *, not_before: float, timeout: float = TIMEOUT) -> Scan:
        rng = np.random.default_rng((SEED, self.first, self.scans))
        true = np.random.default_rng(SEED).integers(4, size=OBJECTS + 2)
        self.scans += 1
        labels = [
            rng.choice(4, p=np.roll(SMOOTH.p_obs[j, self.viewpoint, true[self.first + j]], shift))
            for j, shift in enumerate([int(self.first + j >= self.change) for j in range(2)])
        ]
        return Scan(np.array([[label, 0.0, 0.0] for label in labels]), np.eye(4), stamp=not_before)


def policy() -> Threshold:
    return Threshold(SMOOTH, 0.9)


def drifting_run(
    path: Path, drift: Drift | None = WATCHED, change: int = CHANGE, **settings: Any
) -> SortingReport:
    with Journal(path, **settings) as journal:
        cell = Drifting(change=change)
        return sort_objects(cell, perceive, policy(), SMOOTH, journal, objects=OBJECTS, drift=drift)


def resumed(path: Path, drift: Drift | None = WATCHED) -> SortingReport:
    progress = progress_in(path)
    with Journal(path, resume=True) as journal:
        cell = Drifting(progress.index, progress.scans)
        return resume_sorting(cell, perceive, policy(), journal, drift=drift)


def state(path: Path) -> dict[str, Any]:
    watch = progress_in(path).drift.watch
    assert watch is not None
    return watch.state()


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> tuple[SortingReport, Path]:
    path = tmp_path_factory.mktemp("whole") / "journal.sqlite"
    return drifting_run(path), path


@pytest.mark.slow
def test_tables_that_change_midway_raise_an_alarm(tmp_path: Path, whole: tuple[SortingReport, Path]) -> None:
    assert drifting_run(tmp_path / "as before.sqlite", change=NEVER).drift == ()
    report, path = whole
    entries = read_journal(path)
    first, *_ = drifts(entries)
    assert CHANGE - 1 <= (first.object or 0) < OBJECTS - 20
    assert len(report.drift) == len(drifts(entries))
    steps = list(steps_of(entries))
    surprised = next(
        step for step in steps if any(entry.kind == "drift" for entry in incidents_of(entries, step))
    )
    assert (surprised.alarms, surprised.entry.object) == (0, first.object)
    assert steps[-1].alarms == len(report.drift)


def interrupted(path: Path, kind: str, number: int, **settings: Any) -> None:
    """Run until the n-th entry of a kind has been written."""
    seen = itertools.count(1)

    def listener(entry: Entry) -> None:
        if entry.kind == kind and next(seen) == number:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        drifting_run(path, listener=listener, **settings)


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "number"), [("scan", 1), ("scan", 30), ("decision", 12), ("drift", 1)])
def test_a_resumed_run_has_the_same_watch(
    tmp_path: Path, whole: tuple[SortingReport, Path], kind: str, number: int
) -> None:
    path = tmp_path / "journal.sqlite"
    interrupted(path, kind, number)
    assert resumed(path) == whole[0]
    assert state(path) == state(whole[1])
    assert len(drifts(read_journal(path))) == len(whole[0].drift), "each alarm reported once"


@pytest.mark.slow
def test_an_alarm_whose_entry_is_missing_is_told_when_resumed(
    tmp_path: Path, whole: tuple[SortingReport, Path]
) -> None:
    entries = read_journal(whole[1])
    alarming = entries[entries.index(drifts(entries)[0]) - 1]
    scans = sum(entry.kind == "scan" for entry in entries[: entries.index(alarming) + 1])
    path = tmp_path / "journal.sqlite"
    interrupted(path, "scan", scans)
    assert progress_in(path).drift.unreported
    assert drifts(read_journal(path)) == []
    assert resumed(path) == whole[0]
    assert [e.data for e in drifts(read_journal(path))] == [e.data for e in drifts(entries)]


@pytest.mark.slow
def test_a_snapshot_keeps_the_watch(tmp_path: Path, whole: tuple[SortingReport, Path]) -> None:
    path = tmp_path / "journal.sqlite"
    interrupted(path, "decision", 30, largest=20_000, keep=1)
    assert read_journal(path)[0].kind == "snapshot"
    assert resumed(path).drift == whole[0].drift
    assert state(path) == state(whole[1])


@pytest.mark.slow
def test_an_alarm_holds_the_run_if_asked_to(tmp_path: Path, whole: tuple[SortingReport, Path]) -> None:
    path, holding = tmp_path / "journal.sqlite", Drift(WATCHED.false_alarm, hold=True)
    with pytest.raises(CellError, match=r"\d drift alarms\b.*\bdrift\.hold\b"):
        drifting_run(path, holding)
    states = [entry.data["state"] for entry in read_journal(path) if entry.kind == "state"]
    assert states[-1] == "Held"
    assert resumed(path) == whole[0], "who resumes has looked"


@pytest.mark.slow
def test_a_watch_may_begin_and_end_with_a_resumption(tmp_path: Path) -> None:
    path = tmp_path / "journal.sqlite"
    interrupted(path, "decision", 50, drift=None)
    assert resumed(path).drift == ()
    watch = progress_in(path).drift.watch
    assert watch is not None
    scans = sum(entry.kind == "scan" for entry in read_journal(path))
    assert 0 < sum(watch.state()["looks"][0]) < scans, "from the resumption on"
    assert resumed(path, drift=None).drift == ()
    assert progress_in(path).drift.watch is None


def test_a_state_goes_on_as_its_watch() -> None:
    rng = np.random.default_rng(1)
    watch, belief = DriftWatch(SMOOTH), Belief(SMOOTH)
    for _ in range(30):
        watch.observe(belief, 1, [int(label) for label in rng.integers(4, size=2)])
    twin = DriftWatch.of_state(SMOOTH, json.loads(json.dumps(watch.state())))
    for _ in range(60):
        labels = [int(label) for label in rng.integers(4, size=2)]
        assert twin.observe(belief, 1, labels) == watch.observe(belief, 1, labels)
    assert twin.state() == watch.state()
    assert twin.alarms == watch.alarms


def test_an_infinite_surprise_is_kept() -> None:
    watch, sure = DriftWatch(PAPER), Belief(PAPER, [[1.0, 0.0, 0.0, 0.0]] * 2)
    watch.observe(sure, 0, [2, None])
    text = json.dumps(watch.state(), allow_nan=False)
    twin = DriftWatch.of_state(PAPER, json.loads(text))
    np.testing.assert_array_equal(twin.surprise()[0], watch.surprise()[0])
    assert twin.alarms == watch.alarms
    assert twin.surprise()[0][0, 0] == np.inf
