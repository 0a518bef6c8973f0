import gc
import itertools
import json
import sqlite3
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import FrameType
from typing import Any, get_args

import pytest

from beltsort.cell import MoveTo, SortInto
from beltsort.errors import JournalError
from beltsort.sorting.command import Command
from beltsort.sorting.entries import (
    AnyContent,
    CommandDone,
    Ended,
    Intended,
    Resumed,
    ScanUnusable,
    Snapshot,
    Started,
)
from beltsort.sorting.entry_format import content_of, plain
from beltsort.sorting.journal import Entry, Journal, entries_after, read_journal
from beltsort.sorting.progress import Progress
from tests.account import Account

KILLED_BETWEEN_INTENT_AND_OUTCOME = """
import os, signal, sys
from pathlib import Path
from beltsort.cell import SortInto
from beltsort.sorting.command import Command
from beltsort.sorting.entries import Intended, Started
from beltsort.sorting.journal import Journal
journal = Journal(Path(sys.argv[1]))
journal.append(Started(run="a", objects=1, model=""))
journal.append(Intended(Command("a-sort-1", SortInto(3), "boot")))
os.kill(os.getpid(), signal.SIGKILL)
"""

FIXTURES = Path(__file__).parents[1] / "fixtures" / "journal"
"""As version 0.1.0 wrote them before entries had types; only a sort whose intent names its bin is newer."""


def lines_of(name: str) -> list[dict[str, Any]]:
    return [json.loads(line) for line in (FIXTURES / name).read_text().splitlines()]


STORED = lines_of("kinds.jsonl")

START = Started(run="a", objects=1, model="")
RESUME = Resumed(objects=1, model="")
SNAPSHOT = Snapshot(
    model="", run="a", objects=1, index=0, viewpoint=0, arrived=True, steps=0, commands=0, scans=0,
    stopped=0.0, bin=None, belief=[[0.5, 0.5]], last_labels=[[-1]], next="choice", pending=None, visible=[],
)  # fmt: skip


def test_entries_read_back_as_written(tmp_path: Path) -> None:
    heard: list[Entry] = []
    with Journal(tmp_path / "j", heard.append) as journal:
        journal.append(START)
        journal.object = 0
        journal.append(Intended(Command("a-sort-1", SortInto(3), "boot")))
        journal.append(CommandDone("a-sort-1", stopped=0.1))
    entries = read_journal(tmp_path / "j")
    assert entries == heard
    assert [(e.number, e.kind, e.object) for e in entries] == [
        (1, "start", None),
        (2, "intent", 0),
        (3, "outcome", 0),
    ]


def test_a_killed_process_loses_nothing_that_was_appended(tmp_path: Path) -> None:
    path = tmp_path / "journal.sqlite"
    killed = subprocess.run([sys.executable, "-c", KILLED_BETWEEN_INTENT_AND_OUTCOME, path], check=False)
    assert killed.returncode == -9
    assert [entry.content for entry in read_journal(path)] == [
        START,
        Intended(Command("a-sort-1", SortInto(3), "boot")),
    ]


def test_a_run_never_overwrites_another(tmp_path: Path) -> None:
    Journal(tmp_path / "j").close()
    with pytest.raises(JournalError, match=r"/j exists\b"):
        Journal(tmp_path / "j")


def test_a_folder_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    with pytest.raises(JournalError, match=r"/missing/j .*unable to open"):
        Journal(tmp_path / "missing" / "j")


def test_a_full_disk_is_told_and_keeps_what_was_written(tmp_path: Path, account: Account) -> None:
    account.injected("journal")
    journal = Journal(tmp_path / "j")
    journal.append(START)
    journal._database.execute("PRAGMA max_page_count=1")
    with pytest.raises(JournalError, match=r"/j .*\bdisk is full\b"):
        journal.append(ScanUnusable("x" * 100_000))
    journal.close()
    assert [entry.kind for entry in read_journal(tmp_path / "j")] == ["start"]


def test_what_is_no_journal_is_refused(tmp_path: Path) -> None:
    with pytest.raises(JournalError, match=r"/none .*\bjournal\.sqlite\b"):
        read_journal(tmp_path / "none")
    (tmp_path / "text").write_text("no database, but a long enough text to be looked at " * 20)
    with pytest.raises(JournalError, match=r"/text .*not a database"):
        read_journal(tmp_path / "text")
    sqlite3.connect(tmp_path / "other").execute("CREATE TABLE t (x)").connection.close()
    with pytest.raises(JournalError, match=r"/other .*\bversion\b.*\b2\b.*\b0\b"):
        read_journal(tmp_path / "other")


def test_interrupts_at_any_moment_leave_a_readable_journal(tmp_path: Path) -> None:
    """Entries are numbered by the database, so an interrupt cannot make two of them collide.

    Python handles signals between two instructions only: each of an entry's is interrupted once.
    """
    path = tmp_path / "journal.sqlite"
    written, instruction = 0, 0
    with Journal(path) as journal:
        while interrupted_at(instruction, journal.append):
            last = journal._database.execute("SELECT coalesce(max(number), 0) FROM entries").fetchone()[0]
            assert last in (written, written + 1), "what was interrupted is written whole, or not at all"
            written, instruction = last, instruction + 1
        assert 0 < written < instruction, "interrupted before an entry was written, and after"
        assert journal.append(Ended("done")).number == written + 2
    entries = read_journal(path)
    assert [entry.number for entry in entries] == list(range(1, written + 3))
    assert [entry.kind for entry in entries] == ["bad_scan"] * (written + 1) + ["end"]


def interrupted_at(number: int, append: Callable[[AnyContent], Entry]) -> bool:
    """Append a scan, and raise KeyboardInterrupt before one of its instructions; tell if it has so many."""
    instructions = itertools.count()

    def trace(frame: FrameType, event: str, _argument: object) -> Any:
        frame.f_trace_opcodes = True
        if event == "opcode" and next(instructions) == number:
            raise KeyboardInterrupt
        return trace

    # Python swallows what is raised in callbacks of the garbage collector; other tests leave some there.
    gc.disable()
    tracing_before = sys.gettrace()
    sys._getframe().f_trace_opcodes = True  # Python 3.12 traces instructions only if asked before
    sys.settrace(trace)
    try:
        append(ScanUnusable("dark"))
    except KeyboardInterrupt:
        return True
    finally:
        sys.settrace(tracing_before)
        gc.enable()
    assert next(instructions) <= number, "the interrupt was swallowed"
    return False


def test_a_journal_goes_on_where_it_ended(tmp_path: Path) -> None:
    path = tmp_path / "journal.sqlite"
    with Journal(path) as journal:
        journal.append(START)
    with Journal(path, resume=True) as journal:
        journal.append(RESUME)
    assert [(entry.number, entry.kind) for entry in read_journal(path)] == [(1, "start"), (2, "resume")]
    with pytest.raises(JournalError, match=r"/none .*\bjournal\.sqlite\b"):
        Journal(tmp_path / "none", resume=True)


def test_rotation_bounds_the_size_and_keeps_the_numbers(tmp_path: Path) -> None:
    path = tmp_path / "journal.sqlite"
    with Journal(path, keep=2) as journal:
        for number in range(1, 6):
            journal.append(ScanUnusable("dark"))
            journal.rotate(replace(SNAPSHOT, index=number))
    kept = read_journal(path)
    assert [entry.number for entry in kept] == list(range(kept[0].number, 11))
    assert kept[0].content == replace(SNAPSHOT, index=3), (
        "the oldest file that is kept begins with a snapshot"
    )
    assert len(list(tmp_path.glob("journal*.sqlite"))) == 3


def test_a_crash_in_the_middle_of_rotation_loses_nothing(tmp_path: Path) -> None:
    path = tmp_path / "journal.sqlite"
    with Journal(path) as journal:
        journal.append(START)
    path.rename(tmp_path / "journal-0001.sqlite")
    with Journal(path, resume=True) as journal:
        assert journal.append(RESUME).number == 2
    assert [entry.kind for entry in read_journal(path)] == ["start", "resume"]


@pytest.mark.parametrize("stored", STORED, ids=lambda stored: stored["kind"])
def test_entries_of_earlier_versions_are_read(stored: dict[str, Any]) -> None:
    content = content_of(stored["kind"], stored["data"])
    assert content.kind == stored["kind"]
    assert contains(plain(content), stored["data"])


def test_a_command_is_kept_as_ever() -> None:
    stored = [line["data"] for line in STORED if line["kind"] == "intent"]
    move, sort, into = (content_of("intent", data) for data in stored)
    assert move == Intended(Command("c77e10e4-move-1", MoveTo(0), "simulated", arriving=True))
    assert sort == Intended(Command("16a43316-sort-4.2", SortInto(2), "simulated", attempt=2))
    assert into == Intended(Command("5e0c9a41-sort-3", SortInto(1), "simulated"), "livarno", 3)
    assert [plain(sort), plain(into)] == stored[1:]


def contains(whole: Any, part: Any) -> bool:
    """Tell whether plain data has all that other plain data has; null counts as left out."""
    if isinstance(part, dict):
        return all(contains(whole.get(name), value) for name, value in part.items())
    return bool(whole == part)


def test_a_run_of_an_earlier_version_is_read_to_the_same_state() -> None:
    entries = [
        Entry(line["number"], line["time"], line["object"], content_of(line["kind"], line["data"]))
        for line in lines_of("run.jsonl")
    ]
    progress, state = Progress.after(entries), json.loads((FIXTURES / "state.json").read_text())
    assert progress.steps == state["steps"]
    assert [[d.object, d.label, d.looks] for d in progress.decisions] == state["decisions"]
    again = plain(progress.snapshot())
    assert {name: again.get(name) for name in state["snapshot"]} == state["snapshot"]
    restored = Progress.after([Entry(1, "", 0, progress.snapshot())])
    assert restored.snapshot() == progress.snapshot()


def test_there_is_an_entry_of_every_kind() -> None:
    assert {stored["kind"] for stored in STORED} == {form.kind for form in get_args(AnyContent)}


@pytest.mark.parametrize(
    ("kind", "data", "named"),
    [
        ("decison", {}, "decison"),
        ("end", {}, "reason"),
        ("end", {"reason": "done", "becuase": "x"}, "becuase"),
        ("passed", {"index": "many"}, "index"),
        ("intent", {"command": {"id": "a-cut-1", "name": "cut", "target": 1, "boot_id": "b"}}, "cut"),
        ("intent", {"command": {"id": "a-sort-1", "name": "sort", "target": "x", "boot_id": "b"}}, "target"),
        ("intent", {"command": {"name": ["sort"], "target": 1}}, "name"),
        ("intent", [], "dictionary"),
    ],
)
def test_an_entry_that_nobody_knows_is_refused(kind: str, data: Any, named: str, tmp_path: Path) -> None:
    path = tmp_path / "journal.sqlite"
    with Journal(path) as journal:
        journal.append(START)
        journal._database.execute("INSERT INTO entries VALUES (2, '', ?, NULL, ?)", (kind, json.dumps(data)))
    with pytest.raises(JournalError, match=rf"journal\.sqlite: entry 2 .*\b{named}\b"):
        read_journal(path)


def test_reading_writes_nothing(tmp_path: Path) -> None:
    path = tmp_path / "journal.sqlite"

    def files() -> dict[str, bytes]:
        return {file.name: file.read_bytes() for file in tmp_path.iterdir() if not file.name.endswith("-shm")}

    with Journal(path) as journal:
        journal.append(START)
        before = files()
        assert "journal.sqlite-wal" in before
        assert len(read_journal(path)) == 1
        assert files() == before
        journal.append(RESUME)
        assert [entry.number for entry in entries_after(path, 1)] == [2]
    before = files()
    assert before.keys() == {"journal.sqlite"}
    assert len(read_journal(path)) == 2
    assert files() == before


def test_a_reader_does_not_delay_the_writer(tmp_path: Path) -> None:
    path = tmp_path / "journal.sqlite"
    with Journal(path) as journal:
        journal.append(START)
        reader = sqlite3.connect(f"file:{path}?mode=ro", uri=True, isolation_level=None)
        reader.execute("BEGIN")
        assert reader.execute("SELECT count(*) FROM entries").fetchone() == (1,)
        for _ in range(50):
            journal.append(RESUME)
        assert reader.execute("SELECT count(*) FROM entries").fetchone() == (1,)
        reader.close()
        assert len(read_journal(path)) == 51
