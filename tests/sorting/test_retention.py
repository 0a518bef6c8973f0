"""Which runs are removed, and that no others are, also while another process writes one."""

import os
import sqlite3
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import timedelta
from pathlib import Path

import pytest

from beltsort import ArgumentError
from beltsort.cell import CommandError
from beltsort.errors import JournalError
from beltsort.sorting.holds import HeldError
from beltsort.sorting.journal import Journal, read_journal
from beltsort.sorting.journal_files import JOURNAL
from beltsort.sorting.journal_queries import has_entries
from beltsort.sorting.retention import Pruning, old_runs, prune, prune_quietly
from beltsort.sorting.runs import CELL, DRY_RUN, LOCK, REMOVED, journal_of, unfinished_run
from tests.sorting.test_recovery import PAPER, Controller, begin
from tests.sorting.test_unfinished_run import sort
from tests.waiting import wait_until

LONG_AGO = 1_500_000_000.0


def run_in(folder: Path, cell: str = "a", *, finished: bool = True, aged: bool = True) -> Path:
    """Make a run of two objects, finished or stopped by a person, and let it be old."""
    sort(folder, 2, stop_at=None if finished else 1)
    (folder / CELL).write_text(f"/cells/{cell}.toml\n")
    (folder / "calls.jsonl").write_text("{}\n")
    (folder / "scans").mkdir()
    (folder / "scans" / "1.npz").write_bytes(b"x" * 100)
    if aged:
        os.utime(folder / JOURNAL, (LONG_AGO, LONG_AGO))
    return folder


def names(pruning: Pruning) -> tuple[list[str], list[str]]:
    return [run.folder.name for run in pruning.old], [run.folder.name for run in pruning.kept]


def test_the_newest_of_each_cell_stay(tmp_path: Path) -> None:
    for name, cell in [("1", "a"), ("2", "b"), ("3", "a"), ("4", "a"), (f"5{DRY_RUN}", "a"), ("6", "a")]:
        run_in(tmp_path / name, cell)
    assert names(old_runs(tmp_path, keep=2)) == (["1", "3"], ["2", "4", f"5{DRY_RUN}", "6"])
    assert names(old_runs(tmp_path, keep=1, cell=Path("/cells/a.toml")))[0] == ["1", "3", "4"]
    assert names(old_runs(tmp_path))[0] == ["1", "3", "4"]
    os.utime(tmp_path / "3" / JOURNAL)
    assert names(old_runs(tmp_path, older_than=timedelta(days=30)))[0] == ["1", "4"]
    (tmp_path / "6" / CELL).unlink()  # of an older version: it counts as each cell's
    assert names(old_runs(tmp_path))[0] == ["1", "2", "3", "4"]
    assert len(list(tmp_path.iterdir())) == 6, "nothing was removed"


@pytest.mark.parametrize("finished", [True, False])
def test_the_same_run_is_resumed_before_and_after(tmp_path: Path, finished: bool) -> None:
    cell = Path("/cells/a.toml")
    for name, ended in [("1", False), ("2", True), ("3", False), ("4", finished)]:
        run_in(tmp_path / name, finished=ended)
    resumed = unfinished_run(tmp_path, cell, dry_run=False)
    assert names(prune(tmp_path)) == (["1", "2", "3"], ["4"])
    assert unfinished_run(tmp_path, cell, dry_run=False) == resumed == (None if finished else tmp_path / "4")


def test_a_run_is_removed_with_all_its_files(tmp_path: Path) -> None:
    old, newest = run_in(tmp_path / "1"), run_in(tmp_path / "2")
    size = sum(file.stat().st_size for file in old.rglob("*") if file.is_file())
    (tmp_path / "notes").mkdir()  # no run
    (tmp_path / "linked").symlink_to(newest)
    pruning = prune(tmp_path)
    assert pruning.size == size
    assert sorted(file.name for file in tmp_path.iterdir()) == ["2", "linked", "notes"]


def test_what_a_removal_that_was_cut_short_has_left_is_no_run(tmp_path: Path) -> None:
    run_in(tmp_path / "1")
    run_in(tmp_path / f"2{REMOVED}")
    assert journal_of(tmp_path) == tmp_path / "1" / JOURNAL
    assert names(prune(tmp_path)) == ([], ["1"])
    assert [folder.name for folder in tmp_path.iterdir()] == ["1"]


def test_runs_that_never_began_do_not_count(tmp_path: Path) -> None:
    run_in(tmp_path / "1")
    for name in ("0", "2"):
        (tmp_path / name).mkdir()
        (tmp_path / name / LOCK).touch()
        Journal(tmp_path / name / JOURNAL).close()
    (tmp_path / "2" / JOURNAL).unlink()
    found = old_runs(tmp_path)
    assert names(found) == (["0"], ["1", "2"])
    assert names(old_runs(tmp_path, older_than=timedelta(days=30)))[0] == []


def test_what_a_person_must_look_at_stays(tmp_path: Path) -> None:
    (tmp_path / "1").mkdir()
    with pytest.raises(HeldError):
        begin(tmp_path / "1", Controller(PAPER, breaks={"sort": [CommandError]}))
    (tmp_path / "1" / CELL).write_text("/cells/a.toml\n")
    killed = run_in(tmp_path / "2")
    with sqlite3.connect(killed / JOURNAL) as database:
        sorts = "kind = 'intent' AND data LIKE '%\"sort\"%'"
        database.execute(
            f"DELETE FROM entries WHERE number > (SELECT min(number) FROM entries WHERE {sorts})"
        )
    database.close()
    run_in(tmp_path / "3")
    (tmp_path / "3" / JOURNAL).write_text("x" * 5000)
    run_in(tmp_path / "4")
    run_in(tmp_path / "5")
    found = prune(tmp_path)
    assert names(found) == (["4"], ["1", "2", "3", "5"])
    held, sorting, damaged, _newest = (kept.why for kept in found.kept)
    assert held == "it is held: see `beltsort status`"
    assert "nobody has said whether it was done" in sorting
    assert "cannot be read" in damaged


def test_a_run_that_comes_into_use_meanwhile_stays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    old = run_in(tmp_path / "1")
    run_in(tmp_path / "2")
    with other_process(old, writes=False):
        monkeypatch.setattr("beltsort.sorting.retention.in_use", lambda _path: False)  # as a moment ago
        found = prune(tmp_path)
    assert names(found) == ([], ["1", "2"])
    assert "in use by process" in found.kept[0].why
    assert read_journal(old / JOURNAL)


WRITER = """
import sys
from pathlib import Path
from beltsort.sorting.locks import locked
from beltsort.sorting.runs import LOCK
from tests.sorting.test_unfinished_run import sort
folder = Path(sys.argv[1])
if sys.argv[2] == "writes":
    folder.mkdir()
with locked("the run", folder / LOCK):
    print("locked", flush=True)
    if sys.argv[2] == "writes":
        from itertools import repeat
        import beltsort
        from beltsort.sorting.journal import Journal
        from beltsort.sorting.loop import sort_objects
        from tests.sorting.scripted_cell import LookOnce, ScriptedCell, scripted
        model = beltsort.models.paper()
        with Journal(folder / "journal.sqlite") as journal:
            perceive = scripted(repeat([0, 1]))
            sort_objects(ScriptedCell(model), perceive, LookOnce(), model, journal, objects=None)
    sys.stdin.read()
"""


@contextmanager
def other_process(folder: Path, *, writes: bool) -> Iterator[None]:
    """Let another process hold the lock of a run, and write it."""
    arguments = [sys.executable, "-c", WRITER, str(folder), "writes" if writes else "waits"]
    with subprocess.Popen(arguments, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            assert process.stdout.readline() == "locked\n"
            yield
            assert process.poll() is None, "it goes on"
        finally:
            process.kill()


def test_a_run_that_another_process_writes_goes_on(tmp_path: Path) -> None:
    live = tmp_path / "1"
    run_in(tmp_path / "2")
    newest = run_in(tmp_path / "3")

    def entries() -> int:
        return len(read_journal(live / JOURNAL)) if has_entries(live / JOURNAL) else 0

    with other_process(live, writes=True):
        wait_until(lambda: entries() > 20, "the first entries")
        (live / CELL).write_text((newest / CELL).read_text())
        found = prune(tmp_path)
        assert names(found) == (["2"], ["1", "3"])
        assert "in use by process" in found.kept[0].why
        before = entries()
        wait_until(lambda: entries() > before, "further entries")
    assert sorted(folder.name for folder in tmp_path.iterdir()) == ["1", "3"]


def test_wrong_requests(tmp_path: Path) -> None:
    run = run_in(tmp_path / "1")
    with pytest.raises(ArgumentError, match=r"\bkeep is 0, expected at least 1\b"):
        old_runs(tmp_path, keep=0)
    with pytest.raises(ArgumentError, match=r"\bolder_than is .*\bexpected at least 0\b"):
        prune(tmp_path, older_than=timedelta(days=-1))
    with pytest.raises(ArgumentError, match=r"\bis a run, expected a folder of runs\b"):
        prune(run)
    assert has_entries(run / JOURNAL)


def test_what_cannot_be_removed_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run_in(tmp_path / "1")
    run_in(tmp_path / "2")

    def refuse(_folder: Path) -> None:
        raise PermissionError("not yours")

    monkeypatch.setattr("shutil.rmtree", refuse)
    with pytest.raises(JournalError, match=r"/1\.removed cannot be removed: not yours; check\b"):
        prune(tmp_path)


def test_a_run_that_cannot_be_removed_ends_no_other(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("1", "2"):
        run_in(tmp_path / name)

    def refuse(_folder: Path) -> None:
        raise PermissionError("not yours")

    monkeypatch.setattr("shutil.rmtree", refuse)
    with pytest.warns(UserWarning, match=r"\bold runs are not removed: .*\bnot yours\b"):
        prune_quietly(tmp_path, keep=1, cell=Path("/cells/a.toml"))
