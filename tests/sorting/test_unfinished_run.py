"""Which run of a cell goes on, and runs without a fixed end."""

from pathlib import Path

import pytest

import beltsort
from beltsort.errors import JournalError
from beltsort.sorting.entries import Requested, Resumed, Started
from beltsort.sorting.journal import Journal, read_journal
from beltsort.sorting.journal_files import JOURNAL
from beltsort.sorting.loop import resume_sorting, sort_objects
from beltsort.sorting.record import progress_in
from beltsort.sorting.report import SortingReport
from beltsort.sorting.requests import REQUEST, Request, write_request
from beltsort.sorting.runs import CELL, DRY_RUN, folder_of, journal_of, unfinished_run
from beltsort.sorting.status import Condition, status_of
from tests.sorting.scripted_cell import LookOnce, ScriptedCell, scripted

MODEL = beltsort.SortingModel.load("tests/fixtures/paper.json")


def sort(folder: Path, objects: int | None, stop_at: int | None = None) -> SortingReport:
    """Sort, and ask to stop at an object."""
    folder.mkdir(parents=True)
    asked = Request("stop", "ana@cell (test)", "2026-01-01T10:00:00+00:00")
    with Journal(folder / JOURNAL) as journal:

        def check() -> None:
            if journal.object == stop_at:
                write_request(folder, asked)

        return sort_objects(
            *(ScriptedCell(MODEL), scripted([[0, 1]] * 99), LookOnce(), MODEL, journal),
            objects=objects,
            check=check,
            requests=folder,
        )


def test_a_run_without_a_fixed_end_is_stopped_and_resumed(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    report = sort(folder, None, stop_at=7)
    assert report.stopped_by == "ana@cell (test)"
    assert [decision.object for decision in report.decisions] == list(range(7))
    assert not (folder / REQUEST).exists()
    entries = read_journal(folder / JOURNAL)
    assert [entry.kind for entry in entries[-3:]] == ["request", "state", "end"]
    status = status_of(folder)
    assert (status.condition, status.reason) == (Condition.STOPPED, "ana@cell (test) asked to stop")
    assert (status.object, status.objects, status.left) == (7, None, None)
    assert sum(status.bins.values()) == 7
    progress = progress_in(folder / JOURNAL)
    assert (progress.remaining, progress.left, progress.done) == (None, None, False)
    with Journal(folder / JOURNAL, resume=True) as journal:

        def stop_at_nine() -> None:
            if journal.object == 9:
                write_request(folder, Request("stop", "bo", ""))

        report = resume_sorting(
            *(ScriptedCell(MODEL), scripted([[0, 1]] * 99), LookOnce(), journal),
            check=stop_at_nine,
            requests=folder,
        )
    assert [decision.object for decision in report.decisions] == list(range(9))
    kinds = [type(entry.content) for entry in read_journal(folder / JOURNAL)]
    assert (kinds.count(Started), kinds.count(Resumed), kinds.count(Requested)) == (1, 1, 2)


def test_the_newest_run_goes_on_unless_it_is_finished(tmp_path: Path) -> None:
    runs, cell, other = tmp_path / "runs", tmp_path / "cell.toml", tmp_path / "other.toml"
    assert unfinished_run(runs, cell, dry_run=False) is None
    sort(runs / "1", 5, stop_at=2)
    assert unfinished_run(runs, cell, dry_run=False) == runs / "1"  # it does not say what cell it is of
    (runs / "1" / CELL).write_text(f"{other}\n")
    assert unfinished_run(runs, cell, dry_run=False) is None
    (runs / "1" / CELL).write_text(f"{cell}\n")
    assert unfinished_run(runs, cell, dry_run=False) == runs / "1"
    sort(runs / f"2{DRY_RUN}", 5, stop_at=2)
    assert unfinished_run(runs, cell, dry_run=False) == runs / "1"
    assert unfinished_run(runs, cell, dry_run=True) == runs / f"2{DRY_RUN}"
    (runs / "3").mkdir()
    Journal(runs / "3" / JOURNAL).close()  # killed before it began
    assert unfinished_run(runs, cell, dry_run=False) == runs / "1"
    sort(runs / "4", 3)
    assert unfinished_run(runs, cell, dry_run=False) is None, "an older one has been given up"
    (runs / "5").mkdir()
    (runs / "5" / JOURNAL).write_text("x" * 5000)
    with pytest.raises(JournalError):
        unfinished_run(runs, cell, dry_run=False)


def test_latest_is_the_newest_in_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(JournalError, match=r"\blatest has no journal\b"):
        folder_of(Path("latest"))
    for name in ("1", "2"):
        (tmp_path / "runs" / name).mkdir(parents=True)
        (tmp_path / "runs" / name / JOURNAL).touch()
    assert journal_of(Path("latest")) == Path("runs/2") / JOURNAL
    assert folder_of(Path("latest")) == Path("runs/2")
