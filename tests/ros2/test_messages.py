"""Messages of a run, from the entries of its journal."""

from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from beltsort.cell.commands import AdvanceTo
from beltsort.models import paper
from beltsort.ros2.messages import BELIEF, DECISION, STATE, WARN, Published, RunMessages
from beltsort.sorting.command import Command
from beltsort.sorting.entries import (
    AnyContent,
    CommandDone,
    Decided,
    ObjectsPassed,
    Resumed,
    Scanned,
    Started,
)
from beltsort.sorting.holds import HeldError
from beltsort.sorting.journal import Entry
from beltsort.sorting.journal_files import JOURNAL
from beltsort.sorting.progress import Progress
from beltsort.sorting.record import progress_in
from tests.monitoring.runs import resumed, run_of

TIME = "2026-01-01T00:00:00+00:00"


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


def beliefs(published: list[Published]) -> list[Published]:
    return [each for each in published if each.topic == BELIEF.name]


def rows(published: Published) -> list[list[float]]:
    message: Any = published.message
    width = message["layout"]["dim"][1]["size"]
    data = message["data"]
    return [data[i : i + width] for i in range(0, len(data), width)]


@pytest.mark.parametrize("decided", [False, True])
def test_the_belief_follows_a_belt_whose_objects_have_passed(decided: bool) -> None:
    model = paper()
    arrival = pytest.approx(model.arrival.tolist())
    first, second = [0.7, 0.1, 0.1, 0.1], [0.1, 0.1, 0.1, 0.7]
    scan = Scanned(0, [0, 3], [False] * 2, ["object"] * 2, [], [first, second], [[], []])
    messages = RunMessages()
    contents: list[AnyContent] = [Started(run="a", objects=9, model=model.to_json()), scan]
    contents += [Decided(0, 0, 0.7, 1, None)] if decided else []
    for content in contents:
        messages.read(Entry(1, TIME, 0, content))
    (belief,) = beliefs(messages.read(Entry(9, TIME, 0, ObjectsPassed(1))))
    assert rows(belief) == [pytest.approx(second), arrival]
    assert messages.moved == 1
    (belief,) = beliefs(messages.read(Entry(9, TIME, 1, ObjectsPassed(4))))
    assert rows(belief) == [arrival, arrival]
    assert messages.moved == 3


def test_the_belief_follows_an_advance_after_a_resumption() -> None:
    """The run ended between the decision and the advance."""
    model = paper()
    before = Progress.at_start(model)
    before.belief.observe(0, [0, 3])
    second = before.belief.probabilities[1].tolist()
    before.pending = Command("a-advance-1", AdvanceTo(1), "b")
    messages = RunMessages()
    messages.resume(before)
    messages.read(Entry(1, TIME, 0, Resumed(objects=9, model=model.to_json(), beltsort="")))
    done = messages.read(Entry(2, TIME, 0, CommandDone("a-advance-1")))
    (belief,) = beliefs(done)
    assert rows(belief) == [pytest.approx(second), pytest.approx(model.arrival.tolist())]
