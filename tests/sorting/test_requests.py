"""Requests to hold a run and to continue it: read between steps, journalled, and standing over a crash."""

import threading
import time
from collections.abc import Callable
from dataclasses import asdict, replace
from pathlib import Path

import pytest

import beltsort
from beltsort.sorting.entries import Requested, State, StateChanged
from beltsort.sorting.entry_text import EntryFormatter
from beltsort.sorting.journal import Entry, Journal, read_journal
from beltsort.sorting.loop import resume_sorting, sort_objects
from beltsort.sorting.progress import Progress
from beltsort.sorting.report import SortingReport
from beltsort.sorting.requests import (
    REQUEST,
    TOKEN,
    Request,
    drop_requests,
    is_token,
    read_request,
    read_token,
    standing_hold,
    takes_requests,
    taking_requests,
    write_request,
)
from tests.sorting.scripted_cell import LookOnce, ScriptedCell, scripted

MODEL = beltsort.SortingModel.load("tests/fixtures/paper.json")
HOLD = Request("hold", "ana@cell (test)", "2026-01-01T10:00:00+00:00")
GO_ON = Request("continue", "bo@cell (test)", "2026-01-01T10:01:00+00:00")


def sort(
    folder: Path,
    cell: ScriptedCell,
    listener: Callable[[Entry], None] | None = None,
    check: Callable[[], None] = lambda: None,
) -> SortingReport:
    with Journal(folder / "journal.sqlite", listener) as journal:
        return sort_objects(
            *(cell, scripted([[0, 1]] * 9), LookOnce(), MODEL, journal),
            objects=3,
            check=check,
            requests=folder,
        )


def kinds(folder: Path) -> list[str]:
    return [entry.kind for entry in read_journal(folder / "journal.sqlite")]


def test_a_run_is_held_between_steps_until_asked_to_continue(tmp_path: Path) -> None:
    cell, while_held = ScriptedCell(MODEL), []

    def listener(entry: Entry) -> None:
        if entry.kind == "scan" and entry.object == 1:
            write_request(tmp_path, HOLD)
        if isinstance(entry.content, StateChanged) and entry.content.state is State.HELD:
            threading.Thread(target=go_on, args=[len(cell.acts)]).start()

    def go_on(acts: int) -> None:
        time.sleep(0.5)
        while_held.append(len(cell.acts) - acts)
        write_request(tmp_path, GO_ON)

    report = sort(tmp_path, cell, listener)
    assert len(report.decisions) == 3
    assert while_held == [0]
    entries = read_journal(tmp_path / "journal.sqlite")
    place = [entry.kind for entry in entries].index("request")
    contents = [entry.content for entry in entries[place : place + 4]]
    assert contents[0] == Requested(**asdict(HOLD))
    assert contents[1] == StateChanged(State.HELD, "ana@cell (test) asked to hold")
    assert contents[2] == Requested(**asdict(GO_ON))
    assert contents[3] == StateChanged(State.EXECUTE, "bo@cell (test) asked to continue")
    assert entries[place + 4].kind == "intent"  # the camera is moved back first
    assert cell.acts[3 + 1] == ("move", 1)


def test_the_camera_is_moved_back_after_a_hold_without_a_step(tmp_path: Path) -> None:
    def listener(entry: Entry) -> None:
        if entry.kind == "scan" and entry.object == 0:
            write_request(tmp_path, HOLD)
            threading.Timer(0.4, write_request, [tmp_path, GO_ON]).start()

    held, plain = ScriptedCell(MODEL), ScriptedCell(MODEL)
    (tmp_path / "plain").mkdir()
    assert sort(tmp_path, held, listener) == sort(tmp_path / "plain", plain)
    assert len(held.acts) == len(plain.acts) + 1
    entries = read_journal(tmp_path / "journal.sqlite")
    assert (
        Progress.after(entries).steps == Progress.after(read_journal(tmp_path / "plain/journal.sqlite")).steps
    )


def test_a_hold_stands_over_a_crash(tmp_path: Path) -> None:
    class KilledError(BaseException):
        pass

    asked = 0

    def check() -> None:
        nonlocal asked
        asked += 1
        if asked == 4:
            write_request(tmp_path, HOLD)
        if asked == 6:
            raise KilledError

    cell = ScriptedCell(MODEL)
    with pytest.raises(KilledError):
        sort(tmp_path, cell, check=check)
    assert kinds(tmp_path)[-3:] == ["state", "state", "end"]

    def continue_once_held(entry: Entry) -> None:
        if entry.kind == "request":
            threading.Timer(0.3, write_request, [tmp_path, GO_ON]).start()

    acts = len(cell.acts)
    with Journal(tmp_path / "journal.sqlite", continue_once_held, resume=True) as journal:
        report = resume_sorting(*(cell, scripted([[0, 1]] * 9), LookOnce(), journal), requests=tmp_path)
    assert len(report.decisions) == 3
    resumed = kinds(tmp_path)
    assert resumed[resumed.index("resume") :][:4] == ["resume", "state", "request", "state"]
    assert len(cell.acts) > acts


def test_a_request_to_stop_is_for_one_process(tmp_path: Path) -> None:
    write_request(tmp_path, replace(HOLD, action="stop"))
    with taking_requests(tmp_path):
        assert read_request(tmp_path) is None
        write_request(tmp_path, HOLD)
    with taking_requests(tmp_path):
        assert read_request(tmp_path) == HOLD


def test_an_interrupt_ends_a_held_run(tmp_path: Path) -> None:
    write_request(tmp_path, HOLD)
    asked = 0

    def check() -> None:
        nonlocal asked
        asked += 1
        if asked == 3:
            raise KeyboardInterrupt

    cell = ScriptedCell(MODEL)
    with pytest.raises(KeyboardInterrupt):
        sort(tmp_path, cell, check=check)
    assert cell.acts == []
    states = [
        e.content.state
        for e in read_journal(tmp_path / "journal.sqlite")
        if isinstance(e.content, StateChanged)
    ]
    assert states == [State.EXECUTE, State.HELD, State.STOPPED]


@pytest.mark.parametrize(
    "text", ["", "{", "[]", '{"action": "hold"}', '{"action": "dance", "by": "", "at": ""}']
)
def test_what_is_no_request_is_none(tmp_path: Path, text: str) -> None:
    (tmp_path / REQUEST).write_text(text)
    assert read_request(tmp_path) is None
    assert len(sort(tmp_path, ScriptedCell(MODEL)).decisions) == 3


def test_a_run_that_takes_no_requests_reads_none(tmp_path: Path) -> None:
    write_request(tmp_path, HOLD)
    with Journal(tmp_path / "journal.sqlite") as journal:
        report = sort_objects(
            *(ScriptedCell(MODEL), scripted([[0, 1]] * 9), LookOnce(), MODEL, journal), objects=3
        )
    assert len(report.decisions) == 3


def test_a_token_is_for_one_run_and_one_user(tmp_path: Path) -> None:
    assert not takes_requests(tmp_path)
    assert not is_token(tmp_path, "")
    with taking_requests(tmp_path):
        first = read_token(tmp_path)
        assert first is not None
        assert len(first) >= 40
        assert takes_requests(tmp_path)
        assert is_token(tmp_path, first)
        assert not is_token(tmp_path, first[:-1])
        assert (tmp_path / TOKEN).stat().st_mode & 0o777 == 0o600
    assert not is_token(tmp_path, first)
    with taking_requests(tmp_path):
        assert read_token(tmp_path) != first


def test_a_run_without_requests_drops_what_an_earlier_one_left(tmp_path: Path) -> None:
    write_request(tmp_path, HOLD)
    assert standing_hold(tmp_path) == HOLD
    drop_requests(tmp_path)
    assert standing_hold(tmp_path) is None
    assert list(tmp_path.iterdir()) == []


def test_a_hold_and_its_end_are_shown(tmp_path: Path) -> None:
    write_request(tmp_path, HOLD)
    threading.Timer(0.3, write_request, [tmp_path, GO_ON]).start()
    sort(tmp_path, ScriptedCell(MODEL))
    formatter = EntryFormatter()
    lines = [formatter.format(entry) for entry in read_journal(tmp_path / "journal.sqlite")]
    assert "object  0  held: ana@cell (test) asked to hold" in lines
    assert "object  0  continued: bo@cell (test) asked to" in lines
