"""Messages of a run, from the entries of its journal."""

from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from beltsort.ros2.messages import BELIEF, DECISION, STATE, WARN, Published, RunMessages
from beltsort.sorting.holds import HeldError
from beltsort.sorting.journal import Entry
from beltsort.sorting.journal_files import JOURNAL
from beltsort.sorting.record import progress_in
from tests.monitoring.runs import resumed, run_of


def values_of(published: Published) -> dict[str, str]:
    message: Any = published.message
    return {pair["key"]: pair["value"] for pair in message["status"][0]["values"]}


def all_of(messages: RunMessages, entries: list[Entry]) -> dict[str, list[Published]]:
    found: dict[str, list[Published]] = {topic.name: [] for topic in (STATE, BELIEF, DECISION)}
    for entry in entries:
        for published in messages.read(entry):
            found[published.topic].append(published)
    return found


def test_states_beliefs_and_decisions_of_a_run(tmp_path: Path) -> None:
    entries: list[Entry] = []
    report = run_of(tmp_path, entries.append)
    found = all_of(RunMessages(), entries)
    decisions = [values_of(published) for published in found[DECISION.name]]
    assert [int(decision["object"]) for decision in decisions] == [d.object for d in report.decisions]
    states = [values_of(published) for published in found[STATE.name]]
    assert states[0]["state"] == "Execute"
    assert states[-1]["state"] == "Complete"
    assert (states[-1]["sorted"], states[-1]["empty"], states[-1]["object"]) == ("3", "1", "4")
    assert any("the bin is full" in state["last"] for state in states)
    assert all(earlier != later for earlier, later in pairwise(states))
    belief: Any = found[BELIEF.name][0].message
    positions, classes = (dimension["size"] for dimension in belief["layout"]["dim"])
    assert len(belief["data"]) == positions * classes
    # A belief for the start, for each scan that was used, and for each advance.
    advances = sum(entry.kind == "intent" and "advance" in str(entry.data) for entry in entries)
    scans = sum(entry.kind == "scan" for entry in entries)
    assert len(found[BELIEF.name]) == 1 + scans + advances


def test_a_resumed_run_counts_on(tmp_path: Path) -> None:
    before, messages, entries = RunMessages(), RunMessages(), list[Entry]()
    with pytest.raises(HeldError, match="bin is full"):
        run_of(tmp_path, entries.append, refused=9)
    held: Any = all_of(before, entries)[STATE.name][-1].message
    assert held["status"][0]["level"] == WARN
    assert before.held
    assert before.question is not None
    entries.clear()
    broken_off = progress_in(tmp_path / JOURNAL)
    messages.resume(broken_off)
    resumed(tmp_path, entries.append, first=broken_off.index)
    found = all_of(messages, entries)
    belief: Any = found[BELIEF.name][0].message
    assert belief["data"] == pytest.approx(broken_off.belief.probabilities.ravel().tolist())
    assert values_of(found[STATE.name][-1])["sorted"] == "3"
