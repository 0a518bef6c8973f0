"""A drift watch in the loop: alarms are journalled and told, and the run goes on."""

import itertools
from collections.abc import Sequence
from pathlib import Path

import pytest

from beltsort import Belief, Decide, Move, SortingModel
from beltsort.cli.narrate import Narrator
from beltsort.journal import Entry, Journal, read_journal
from beltsort.sorter import sort_objects
from beltsort.tables import DriftWatch
from tests.loop.scripted_cell import Glimpse, ScriptedCell, scripted

PAPER = SortingModel.load("tests/fixtures/paper.json")


class LookTwiceAndDecide:
    """Looks at every object from the first viewpoint, twice."""

    def __init__(self) -> None:
        self.looks = 0

    def act(self, belief: Belief, viewpoint: int) -> Move | Decide:
        self.looks = (self.looks + 1) % 3
        return Move(0) if self.looks else Decide(belief.most_likely(0)[0])


def sorted_with_watch(
    tmp_path: Path, model: SortingModel, scans: Sequence[Sequence[Glimpse]]
) -> tuple[DriftWatch, list[Entry]]:
    watch, path = DriftWatch(model), tmp_path / "journal.sqlite"
    with Journal(path) as journal:
        sort_objects(
            ScriptedCell(model),
            scripted(itertools.cycle(scans)),
            LookTwiceAndDecide(),
            model,
            journal,
            objects=20,
            watch=watch,
        )
    return watch, read_journal(path)


def lines(entries: list[Entry]) -> list[str]:
    narrator = Narrator()
    return [line for entry in entries if (line := narrator.line(entry))]


def test_an_alarm_is_journalled_after_its_scan_and_told(tmp_path: Path) -> None:
    table = [[[[0.95, 0.05], [0.05, 0.95]]]] * 2
    model = SortingModel(["nut", "bolt"], ["above"], table)
    watch, entries = sorted_with_watch(tmp_path, model, [[0, 0], [1, 1]])
    drifts = [entry for entry in entries if entry.kind == "drift"]
    assert [entry.data for entry in drifts] == [alarm.to_dict() for alarm in watch.alarms]
    assert entries[entries.index(drifts[0]) - 1].kind == "scan"
    assert entries[-1].data == {"reason": "done"}
    told = [line for line in lines(entries) if "no longer come as the tables say" in line]
    assert len(told) == len(watch.alarms) > 0
    assert any("labels at position 1 from above no longer" in line for line in told)
    assert any("warning: labels no longer" in line for line in told)


def test_labels_as_the_tables_say_raise_no_alarm(tmp_path: Path) -> None:
    watch, entries = sorted_with_watch(
        tmp_path, PAPER, [[0, 1], [0, 1], [1, 2], [1, 2], [2, 3], [2, 3], [3, 0], [3, 0]]
    )
    assert watch.alarms == []
    assert all(entry.kind != "drift" for entry in entries)
    mean, _ = watch.surprise()
    assert mean[0, 0] < 0.0


def test_an_impossible_label_is_journalled_too(tmp_path: Path) -> None:
    model = SortingModel(PAPER.classes, PAPER.viewpoints, PAPER.p_obs, arrival=[1.0, 0.0, 0.0, 0.0])
    watch, entries = sorted_with_watch(tmp_path, model, [[2, None]])
    assert [alarm.evidence for alarm in watch.alarms] == [pytest.approx(float("inf"))] * 2
    assert [entry.data["evidence"] for entry in entries if entry.kind == "drift"] == [None, None]
