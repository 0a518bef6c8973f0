"""Copies of runs, also of one that is being written."""

import shutil
import sqlite3
from contextlib import closing, suppress
from dataclasses import dataclass
from pathlib import Path

from beltsort.errors import JournalError, JournalNotWrittenError
from beltsort.sorting.call_log import calls_in
from beltsort.sorting.journal import entries_of_journal, last_row
from beltsort.sorting.journal_files import (
    JOURNAL,
    copied,
    full_files,
    open_to_read,
    replaced,
    rows_of,
    transaction,
)
from beltsort.sorting.kept_scans import SCANS, kept_scans, scan_file
from beltsort.sorting.moving.reading import is_moving
from beltsort.sorting.moving.state import MovingState
from beltsort.sorting.progress import Progress
from beltsort.sorting.runs import CELL, MODEL, POLICY, TRUTH, journal_of

PART = ".part"
OTHERS = (MODEL, POLICY, CELL, TRUTH)
"""Files of a run's folder that are copied as they are; each is replaced as a whole where it is written."""


@dataclass(frozen=True)
class Backup:
    """A copy of a run.

    Attributes
    ----------
    path
        Its journal: one file with all entries that were still kept.
    first, last
        Numbers of its first and last entry.
    index
        Number of the object at the belt end after the last entry; on a belt that never stops, of the first
        one that is undecided.
    """

    path: Path
    first: int
    last: int
    index: int


def backup_run(run: Path, target: Path) -> Backup:
    """Copy a run; the copy is checked by reading it and computing the state of the run from it.

    A run that is in progress goes on meanwhile; the copy ends with the last entry that was written when it
    began.

    Parameters
    ----------
    run
        As in `beltsort.sorting.audit.journal_of`.
    target
        If it ends in `.sqlite`, the file of the journal's copy. Otherwise a folder, which is made, for a copy
        of the whole run that can be resumed.

    Raises
    ------
    JournalError
        If there is no journal, it is damaged, or the target exists.
    JournalNotWrittenError
        If the copy cannot be written.
    """
    journal = journal_of(run)
    last_row(journal)
    whole = target.suffix != ".sqlite"
    if target.exists():
        raise JournalError(
            f"{target} exists already, and a backup replaces nothing: name a new file or folder"
        )
    part = target.with_name(f"{target.name}{PART}")
    copy = part / JOURNAL if whole else part
    try:
        _remove(part)
        copy.parent.mkdir(parents=True, exist_ok=True)
        _copy_journal(journal, copy)
        if whole:
            for file in [*(journal.parent / name for name in OTHERS), *calls_in(journal.parent)]:
                if file.exists():
                    shutil.copy2(file, part / file.name)
            _copy_scans(journal.parent, part)
        backup = _checked(copy, target / JOURNAL if whole else target)
        replaced(part, target)
    except (OSError, sqlite3.Error) as reason:
        raise JournalNotWrittenError(
            f"the backup {target} cannot be written: {reason}; check that its folder is writable and that "
            "the disk is not full"
        ) from reason
    finally:
        _remove(part)
    return backup


def _remove(part: Path) -> None:
    """Remove what a backup that failed, or was cut short, has left."""
    if part.is_dir():
        shutil.rmtree(part)
    part.unlink(missing_ok=True)


def _copy_journal(journal: Path, copy: Path) -> None:
    """Copy the entries of all files of a journal to one file, the file being written first.

    Its entries are copied to a full file before they are removed from it, so none is missed.
    """
    with closing(open_to_read(journal)) as source:
        copied(source, copy)
    with closing(sqlite3.connect(copy, isolation_level=None)) as target:
        for file in full_files(journal):
            with closing(open_to_read(file)) as full, transaction(target):
                rows = full.execute("SELECT * FROM entries")
                target.executemany("INSERT OR IGNORE INTO entries VALUES (?, ?, ?, ?, ?)", rows)


def _copy_scans(run: Path, part: Path) -> None:
    """Copy the scans that a run keeps; one that it drops meanwhile is left out."""
    kept = kept_scans(run)
    if kept:
        (part / SCANS).mkdir()
    for entry in kept:
        with suppress(FileNotFoundError):
            shutil.copy2(scan_file(run, entry), scan_file(part, entry))


def _checked(copy: Path, path: Path) -> Backup:
    """Read a copy and return what is in it; `path` is its name later."""
    with closing(open_to_read(copy)) as database:
        (found,) = database.execute("PRAGMA integrity_check(1)").fetchone()
    if found != "ok":
        raise JournalError(f"the copy {copy} is damaged ({found}): check the disk, and back up again")
    ((first, last, count),) = rows_of(copy, "SELECT min(number), max(number), count(*) FROM entries")
    if count != last - first + 1:
        raise JournalError(
            f"the copy {copy} has {count} entries, expected all from {first} to {last}: the journal "
            "lacks some; look at it with `beltsort show`"
        )
    entries = entries_of_journal(copy)
    if is_moving(copy):
        return Backup(path, first, last, MovingState.after(entries).settled)
    return Backup(path, first, last, Progress.after(entries).index)
