"""Journals of version 1 are made into such of today's version."""

import json
import sqlite3
from pathlib import Path
from typing import Any

import pytest

from beltsort.cli import main
from beltsort.errors import JournalError
from beltsort.models import paper
from beltsort.sorting.audit import steps_of
from beltsort.sorting.journal import Journal, read_journal
from beltsort.sorting.journal_files import JOURNAL, SCHEMA
from beltsort.sorting.migration import migrate
from beltsort.sorting.object_history import object_history
from beltsort.sorting.progress import Progress
from tests.sorting.test_journal import START

EVEN = [[0.25] * 4] * 2
SURE = [[0.97, 0.01, 0.01, 0.01], [0.25] * 4]


def command(name: str, number: int, **target: int) -> list[tuple[str, dict[str, Any]]]:
    """Return intent and outcome as version 1 wrote them."""
    known = {"command_id": f"{name}-{number}"}
    return [("intent", {**known, "command": name, **target}), ("outcome", {**known, "done": True})]


def scan(belief: list[list[float]], *, empty: bool = False, **more: Any) -> tuple[str, dict[str, Any]]:
    seen = {"labels": [None if empty else 0, None], "empty": [empty, False], "dropped": []}
    return "scan", {"viewpoint": 1, **seen, "belief": belief, **more}


LAST: dict[str, Any] = {"last_labels": [[-1, -1, -1], [-1, -1, -1]]}
PLAN = {"values": [{"move": 1, "value": 2.0}], "lower": 1.0, "upper": 2.0, "trials": 5}
SORTED = [
    *command("move", 1, viewpoint=0),
    ("plan", {"action": {"move": 1}, **PLAN}),
    *command("move", 2, viewpoint=1),
    ("bad_scan", {"stamp": 1.5, "error": "dark"}),
    scan(SURE, empty=False, **LAST),
    ("plan", {"action": {"decide": 0}}),
    *command("sort", 3, label=0),
    ("decision", {"label": 0, "belief": 0.97, "looks": 1, "forced": None}),
    *command("advance", 4, index=1),
]
SKIPPED = [
    ("plan", {"action": {"move": 1}, "why": "the belt end was seen empty: look again"}),
    *command("move", 5, viewpoint=1),
    scan(EVEN, empty=True),
    ("skip", {"viewpoints": [1]}),
    *command("advance", 6, index=2),
]
INTERRUPTED: list[tuple[str, dict[str, Any]]] = [
    ("plan", {"action": {"decide": 2}}),
    ("intent", {"command_id": "sort-7", "command": "sort", "label": 2}),
    ("outcome", {"command_id": "sort-7", "done": False, "error": "KeyboardInterrupt()"}),
]


def old_run(folder: Path, *parts: list[tuple[str, dict[str, Any]]], version: int = 1) -> Path:
    """Write a journal of version 1."""
    start = {"objects": 3, "model": paper().to_json(), "beltsort": "0.0.1"}
    with sqlite3.connect(folder / JOURNAL) as database:
        database.execute("PRAGMA journal_mode=WAL")
        database.execute(SCHEMA)
        database.execute(f"PRAGMA user_version={version}")
        index = 0
        for kind, data in [("start", start), *(entry for part in parts for entry in part)]:
            database.execute(
                "INSERT INTO entries (time, kind, object, data) VALUES (?, ?, ?, ?)",
                ("2026-11-22T12:00:00+00:00", kind, None if kind == "start" else index, json.dumps(data)),
            )
            index += kind == "outcome" and data["command_id"].startswith("advance")
    database.close()
    return folder


def test_a_run_is_as_it_was(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run = old_run(tmp_path, SORTED, SKIPPED, [("end", {"reason": "done"})])
    before = (run / JOURNAL).read_bytes()
    assert main(["show", str(run)]) == 2
    assert "version 2 (found 1): `beltsort migrate " in capsys.readouterr().err
    assert main(["migrate", str(run)]) == 0
    said = capsys.readouterr()
    assert "durations of plans were not recorded" in said.err
    assert "journal.sqlite.version-1" in said.out
    assert (run / f"{JOURNAL}.version-1").read_bytes()[100:] == before[100:]
    entries = read_journal(run / JOURNAL)
    progress = Progress.after(entries)
    assert (progress.steps, progress.index, progress.skipped) == (3, 2, [1])
    (decision,) = progress.decisions
    assert (decision.object, decision.label, decision.belief, decision.looks) == (0, 0, 0.97, 1)
    assert [step.number for step in steps_of(entries)] == [1, 2, 3]
    assert len(object_history(entries, 0).looks) == 1
    assert main(["show", str(run)]) == 0
    assert "1 sorted, 1 empty, 1 left; 3 steps" in capsys.readouterr().out
    assert main(["migrate", str(run), "--json"]) == 0
    again = json.loads(capsys.readouterr().out)
    assert (again["kept"], again["entries"]) == (None, len(entries))


def test_a_sort_whose_outcome_is_not_known_is_left_out_and_said(tmp_path: Path) -> None:
    end: list[tuple[str, dict[str, Any]]] = [("end", {"reason": "KeyboardInterrupt()"})]
    migrated = migrate(old_run(tmp_path, SORTED, SKIPPED, INTERRUPTED, end))
    assert any("object 2: the sort that was interrupted" in note for note in migrated.notes)
    entries = read_journal(migrated.path)
    assert [entry.kind for entry in entries[-2:]] == ["plan", "end"]
    assert Progress.after(entries).pending is None


def test_a_migration_that_was_cut_short_goes_on(tmp_path: Path) -> None:
    run = old_run(tmp_path, SORTED)
    (run / JOURNAL).rename(run / f"{JOURNAL}.version-1")
    assert migrate(run).entries == len(read_journal(run / JOURNAL))


def test_what_cannot_be_migrated_is_left_as_it_is(tmp_path: Path) -> None:
    run = old_run(tmp_path, SORTED, [("outcome", {"command_id": "move-9", "done": True})])
    before = (run / JOURNAL).read_bytes()
    with pytest.raises(JournalError, match=r"cannot be migrated, and is as it was: .*\bmove-9\b"):
        migrate(run)
    assert (run / JOURNAL).read_bytes() == before
    assert [file.name for file in run.iterdir()] == [JOURNAL]


def test_other_versions_are_refused(tmp_path: Path) -> None:
    with pytest.raises(JournalError, match=r"does not exist"):
        migrate(tmp_path)
    with pytest.raises(JournalError, match=r"of version 7, expected 1 or 2\b"):
        migrate(old_run(tmp_path, version=7))
    (tmp_path / "new").mkdir()
    with Journal(tmp_path / "new" / JOURNAL) as journal:
        journal.append(START)
    assert migrate(tmp_path / "new").kept is None
