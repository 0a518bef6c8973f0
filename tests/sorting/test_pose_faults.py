"""Scans whose pose is wrong are counted in the journal, the report and after a resumption."""

from dataclasses import dataclass
from pathlib import Path

import pytest

import beltsort
from beltsort.cell import Scan
from beltsort.cli.show import show_progress
from beltsort.sorting.entries import Scanned
from beltsort.sorting.journal import Entry, Journal, read_journal
from beltsort.sorting.loop import sort_objects
from beltsort.sorting.progress import Progress
from tests.sorting.scripted_cell import Glimpsed, LookOnce, ScriptedCell

PAPER = beltsort.SortingModel.load("tests/fixtures/paper.json")
FAULT = "the pose is inverted"


@dataclass(frozen=True)
class Doubtful(Glimpsed):
    pose_fault: str | None = None


def test_faults_are_counted_and_told(tmp_path: Path) -> None:
    faults = iter([FAULT, None, FAULT])

    def perceive(_scan: Scan) -> list[Doubtful]:
        fault = next(faults)
        return [Doubtful(0, False, fault)] * 2

    path = tmp_path / "journal.sqlite"
    with Journal(path) as journal:
        report = sort_objects(ScriptedCell(PAPER), perceive, LookOnce(), PAPER, journal, objects=3)
    assert report.pose_faults == {FAULT: 2}
    entries = read_journal(path)
    told = [entry.content.pose_fault for entry in entries if isinstance(entry.content, Scanned)]
    assert told == [FAULT, None, FAULT]
    progress = Progress.after(entries)
    assert progress.pose_faults == {FAULT: 2}
    again = Progress.after([Entry(1, "", None, progress.snapshot())])
    assert again.pose_faults == {FAULT: 2}


def test_show_tells_each_kind(capsys: pytest.CaptureFixture[str]) -> None:
    progress = Progress.at_start(PAPER)
    progress.pose_faults = {FAULT: 7}
    show_progress(progress)
    assert f"7 scans do not show the belt where their pose says; likely: {FAULT}" in capsys.readouterr().out
