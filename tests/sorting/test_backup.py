"""Backups of runs, also while they go on."""

import sqlite3
from pathlib import Path

import pytest

from beltsort.errors import JournalError
from beltsort.models import paper
from beltsort.sorting.backup import Backup, backup_run
from beltsort.sorting.call_log import CALLS
from beltsort.sorting.entries import Snapshot
from beltsort.sorting.journal import Journal, read_journal
from beltsort.sorting.journal_files import JOURNAL
from beltsort.sorting.kept_scans import SCANS, kept_scans
from beltsort.sorting.loop import resume_sorting
from beltsort.sorting.record import progress_in
from beltsort.sorting.runs import MODEL, sort_into
from tests.sorting.scripted_cell import LookOnce, ScriptedCell, scripted


def run_of(folder: Path, objects: int = 6) -> Path:
    """Sort objects in a folder, of which the journal has several files."""
    folder.mkdir()
    model = paper()
    sort_into(folder, ScriptedCell(model), scripted([[1, 2]] * 100), LookOnce(), model, objects=objects)
    (folder / f"{CALLS}.1").write_text("{}\n")
    return folder


def rotated(run: Path, times: int) -> None:
    with Journal(run / JOURNAL, resume=True) as journal:
        for _ in range(times):
            journal.rotate(progress_in(run / JOURNAL).snapshot())


def test_a_backup_has_all_entries_that_are_kept(tmp_path: Path) -> None:
    run = run_of(tmp_path / "run")
    rotated(run, 2)
    backup = backup_run(run, tmp_path / "backups" / "monday")
    copy = tmp_path / "backups" / "monday"
    assert sorted(file.name for file in copy.iterdir()) == sorted([f"{CALLS}.1", JOURNAL, MODEL, SCANS])
    assert kept_scans(copy) == kept_scans(run) != []
    assert read_journal(copy / JOURNAL) == read_journal(run / JOURNAL)
    assert (backup.path, backup.first, backup.index) == (copy / JOURNAL, 1, 6)
    alone = backup_run(run, tmp_path / "journal-of-monday.sqlite")
    assert read_journal(alone.path) == read_journal(run / JOURNAL)
    assert [file.name for file in tmp_path.glob("*.part")] == []


def test_a_backup_of_a_run_in_progress_can_be_resumed(tmp_path: Path) -> None:
    model, run = paper(), tmp_path / "run"
    taken: list[Backup] = []
    run.mkdir()
    cell = ScriptedCell(model)

    def back_up(_: object) -> None:
        if len(cell.acts) == 8 and not taken:
            taken.append(backup_run(run, tmp_path / "copy"))

    perceive = scripted([[1, 2]] * 100)
    sort_into(run, cell, perceive, LookOnce(), model, objects=6, listener=[back_up])
    (backup,) = taken
    assert 0 < backup.index < 6
    assert len(read_journal(run / JOURNAL)) > backup.last, "the run went on"
    with Journal(tmp_path / "copy" / JOURNAL, resume=True) as journal:
        report = resume_sorting(ScriptedCell(model, first=backup.index), perceive, LookOnce(), journal)
    assert [decision.object for decision in report.decisions] == list(range(6))


def test_entries_that_are_in_two_files_are_copied_once(tmp_path: Path) -> None:
    run = run_of(tmp_path / "run")
    with sqlite3.connect(run / "journal-0001.sqlite") as copy, sqlite3.connect(run / JOURNAL) as journal:
        journal.backup(copy)
    entries = read_journal(run / JOURNAL)
    backup = backup_run(run, tmp_path / "copy.sqlite")
    assert read_journal(backup.path) == entries
    assert not any(isinstance(entry.content, Snapshot) for entry in entries)


def test_what_cannot_be_backed_up_is_told(tmp_path: Path) -> None:
    with pytest.raises(JournalError, match=r"/none/journal\.sqlite does not exist"):
        backup_run(tmp_path / "none" / JOURNAL, tmp_path / "copy")
    run = run_of(tmp_path / "run")
    with pytest.raises(JournalError, match=r"/run exists already\b.*\bname a new\b"):
        backup_run(run, run)
    with sqlite3.connect(run / JOURNAL) as journal:
        journal.execute("DELETE FROM entries WHERE number = 5")
    with pytest.raises(JournalError, match=r"entries, expected all from 1 to \d+"):
        backup_run(run, tmp_path / "copy")
    assert not (tmp_path / "copy").exists()
