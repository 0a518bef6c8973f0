"""Files of a journal: rotation beside readers and kills, network disks."""

import sqlite3
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import pytest

from beltsort.errors import JournalNotWrittenError
from beltsort.models import paper
from beltsort.sorting.entries import Ended, ScanUnusable
from beltsort.sorting.journal import Entry, Journal, entries_after, read_journal
from beltsort.sorting.journal_files import JOURNAL, NetworkDiskWarning, full_files
from beltsort.sorting.loop import sort_objects
from beltsort.sorting.progress import Progress
from beltsort.sorting.record import Record, progress_in
from beltsort.util import filesystems
from beltsort.util.filesystems import file_system_of, on_network
from tests.sorting.scripted_cell import EMPTY, Glimpse, LookOnce, ScriptedCell, scripted
from tests.sorting.test_journal import RESUME, SNAPSHOT, START

DARK = ScanUnusable("dark")


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / JOURNAL


def numbers(entries: list[Entry]) -> list[int]:
    return [entry.number for entry in entries]


def test_a_reader_may_read_while_files_rotate(path: Path) -> None:
    """SQLite's files must not be renamed in use: the reader would take the new log for the old file's."""
    with Journal(path) as journal:
        journal.append(START)
        reader = sqlite3.connect(f"file:{path}?mode=ro", uri=True, isolation_level=None)
        reader.execute("BEGIN")
        assert reader.execute("SELECT count(*) FROM entries").fetchone() == (1,)
        journal.append(DARK)
        journal.rotate(SNAPSHOT)
        journal.append(DARK)
        assert reader.execute("SELECT count(*) FROM entries").fetchone() == (1,)
        reader.execute("COMMIT")
        assert reader.execute("SELECT number FROM entries").fetchall() == [(3,), (4,)]
        reader.close()
        assert numbers(read_journal(path)) == [1, 2, 3, 4]
        assert numbers(entries_after(path, 1)) == [2, 3, 4]
        assert numbers(entries_after(path, 3)) == [4]
        assert entries_after(path, 4) == []


def test_a_file_that_has_been_rotated_is_not_full(path: Path) -> None:
    with Journal(path, largest=50_000) as journal:
        for _ in range(3):
            while not journal.full:
                journal.append(ScanUnusable("x" * 5_000))
            journal.rotate(SNAPSHOT)
            assert not journal.full
    assert path.stat().st_size < 100_000


class Killed(BaseException):
    """The process ends here."""


@pytest.mark.parametrize("when", ["before the copy", "in the copy", "after the copy", "at the snapshot"])
def test_a_kill_at_any_time_of_a_rotation_leaves_a_whole_journal(
    path: Path, when: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def kill(*_: object) -> None:
        raise Killed

    module = "beltsort.sorting.journal"
    where = {
        "before the copy": f"{module}.Journal._drop_oldest",
        "in the copy": "beltsort.sorting.journal_files.replaced",
        "after the copy": f"{module}.transaction",
        "at the snapshot": f"{module}.Journal._insert",
    }
    with Journal(path) as journal:
        journal.append(START)
        journal.append(DARK)
        with monkeypatch.context() as patched:
            patched.setattr(where[when], kill)
            with pytest.raises(Killed):
                journal.rotate(SNAPSHOT)
    assert numbers(read_journal(path)) == [1, 2]
    with Journal(path, resume=True) as journal:
        assert journal.whole
        journal.append(DARK)
        journal.rotate(SNAPSHOT)
        journal.append(RESUME)
    entries = read_journal(path)
    assert numbers(entries) == [1, 2, 3, 4, 5], "no entry twice, whichever files it is in"
    assert [entry.kind for entry in entries[-2:]] == ["snapshot", "resume"]


def test_a_file_without_its_beginning_is_mended_when_the_run_resumes(path: Path) -> None:
    """Earlier versions renamed the full file, and were killed before they wrote the snapshot."""
    with Journal(path) as journal:
        journal.append(replace(START, model=paper().to_json(), objects=1))
    path.rename(path.with_name("journal-0001.sqlite"))
    with Journal(path, resume=True) as journal:
        assert not journal.whole
        record = Record.resumed(journal)
        assert journal.whole
        record(RESUME)
    assert [entry.kind for entry in read_journal(path)] == ["start", "snapshot", "resume"]
    full_files(path)[0].unlink()
    assert progress_in(path).objects == 1, "the older file is not needed"


def test_files_that_others_need_are_not_dropped(path: Path) -> None:
    """A file of an earlier version that began without a snapshot keeps the one before it."""
    with Journal(path, keep=1) as journal:
        journal.append(START)
        journal.rotate(SNAPSHOT)
        journal._database.execute("UPDATE entries SET kind = 'bad_scan'")
        journal.rotate(SNAPSHOT)
        assert [file.name for file in full_files(path)] == ["journal-0001.sqlite", "journal-0002.sqlite"]
        journal.rotate(SNAPSHOT)
    assert len(full_files(path)) == 1
    assert numbers(read_journal(path)) == [3, 4]


def test_a_disk_that_is_full_in_a_rotation_loses_nothing(path: Path) -> None:
    with Journal(path) as journal:
        journal.append(START)
        path.with_name("journal-0001.sqlite.part").mkdir()
        with pytest.raises(JournalNotWrittenError, match=r"\brotated\b"):
            journal.rotate(SNAPSHOT)
        journal.append(Ended("full"))
    assert [entry.kind for entry in read_journal(path)] == ["start", "end"]


MOUNTS = """\
22 1 8:1 / / rw,relatime shared:1 - ext4 /dev/sda1 rw
45 22 0:40 / /mnt/my\\040share rw,relatime shared:2 - nfs4 server:/share rw
46 22 0:41 / /mnt/my\\040share/local rw - tmpfs tmpfs rw
47 22 0:42 / /mnt/remote rw - fuse.sshfs user@server: rw
"""


@pytest.mark.parametrize(
    ("place", "kind", "network"),
    [
        ("/var/runs", "ext4", False),
        ("/mnt/my share/runs", "nfs4", True),
        ("/mnt/my share/local/runs", "tmpfs", False),
        ("/mnt/remote", "fuse.sshfs", True),
        ("/mnt/remotes", "ext4", False),
    ],
)
def test_network_disks_are_known_by_their_mounts(
    place: str, kind: str, network: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    mounts = tmp_path / "mountinfo"
    mounts.write_text(MOUNTS)
    monkeypatch.setattr(filesystems, "MOUNTS", mounts)
    assert file_system_of(Path(place)) == kind
    assert on_network(Path(place)) == network
    monkeypatch.setattr(filesystems, "MOUNTS", tmp_path / "none")
    assert file_system_of(Path(place)) == ""


def test_a_network_disk_has_no_write_ahead_log(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    mounts = path.with_name("mountinfo")
    mounts.write_text("22 1 8:1 / / rw - nfs4 server:/ rw\n")
    monkeypatch.setattr(filesystems, "MOUNTS", mounts)
    with pytest.warns(NetworkDiskWarning, match=r"journal\.sqlite\b.*\bnfs4\b.*\blocal disk\b"):
        journal = Journal(path)
    with journal:
        journal.append(START)
        assert not path.with_name(f"{JOURNAL}-wal").exists()
        assert numbers(read_journal(path)) == [1]
        journal.append(DARK)
        assert numbers(entries_after(path, 1)) == [2]
        journal.rotate(SNAPSHOT)
    assert numbers(read_journal(path)) == [1, 2, 3]
    with pytest.warns(NetworkDiskWarning), Journal(path, resume=True) as journal:
        assert journal.append(RESUME).number == 4


def test_a_rollback_journal_that_a_kill_left_is_rolled_back_by_readers(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("beltsort.sorting.journal_files.on_network", lambda _path: True)
    with pytest.warns(NetworkDiskWarning):
        journal = Journal(path)
    with journal:
        journal.append(START)
        journal._database.execute("PRAGMA cache_size=1")
        journal._database.execute("BEGIN")
        for _ in range(50):
            journal.append(ScanUnusable("x" * 5_000))
        whole, log = path.read_bytes(), path.with_name(f"{JOURNAL}-journal").read_bytes()
        journal._database.execute("ROLLBACK")
    path.write_bytes(whole)
    path.with_name(f"{JOURNAL}-journal").write_bytes(log)
    assert numbers(read_journal(path)) == [1]


def test_the_state_of_a_long_run_is_read_from_its_newest_file(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is the state that all entries give; decisions and empty cups of the other files are there."""
    model = paper()
    seen: list[Sequence[Glimpse] | str] = [[1, 2], [EMPTY, 2], [EMPTY, 2], *[[2, 3]] * 50]
    with Journal(path, largest=12_000, keep=99) as journal:
        sort_objects(ScriptedCell(model), scripted(seen), LookOnce(), model, journal, objects=12)
    assert len(full_files(path)) >= 3
    whole, progress = Progress.after(read_journal(path)), progress_in(path)
    assert progress.decisions == whole.decisions
    assert progress.skipped == whole.skipped == [1]
    assert progress.snapshot() == whole.snapshot()
    assert progress.taken == whole.taken
    read: list[str] = []
    monkeypatch.setattr("beltsort.sorting.journal.read_journal", lambda path: read.append(str(path)))
    progress_in(path)
    assert read == []
