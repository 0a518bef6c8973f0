"""The durable record of a run.

An append-only list of entries in SQLite files. Every entry is on the disk before the call that wrote it
returns (synchronous=FULL), so that the cell's actions are known after any crash, except for the outcome of
one command: the *intent* that no *outcome* follows.

A long run is kept in several files, of which the oldest are dropped: `journal.sqlite` is being written, the
full ones beside it are numbered (`journal-0001.sqlite`). docs/journal.md describes the format.
"""

import json
import sqlite3
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from beltsort._core import __version__
from beltsort.errors import JournalError, JournalNotWrittenError
from beltsort.sorting.entries import AnyContent, Snapshot, Started, Unheard
from beltsort.sorting.entry_format import content_of, plain
from beltsort.sorting.journal_files import (
    copied,
    first_kind,
    full_files,
    next_full_file,
    open_journal,
    open_to_read,
    rows_of,
    transaction,
)
from beltsort.sorting.moving.entries import MovingSnapshot, MovingStarted


@dataclass(frozen=True)
class Entry:
    """One line of the journal.

    Attributes
    ----------
    number
        Counts from 1.
    time
        UTC, ISO 8601.
    object
        Number of the object at the belt end; None before the first.
    content
        The content of the entry.
    """

    number: int
    time: str
    object: int | None
    content: AnyContent

    @property
    def kind(self) -> str:
        """The kind of its content."""
        return self.content.kind

    @property
    def data(self) -> dict[str, Any]:
        """Its content as plain data, as stored in JSON."""
        return plain(self.content)

    def plain(self) -> dict[str, Any]:
        """Return the entry as plain data."""
        return {name: getattr(self, name) for name in ("number", "time", "kind", "object", "data")}


Listener = Callable[[Entry], None]
Listeners = Listener | Sequence[Listener | None] | None
"""One listener, several, or none."""

BATCH = 1000
"""Number of entries that are read at once."""

WHOLE = (Started.kind, Snapshot.kind, MovingStarted.kind, MovingSnapshot.kind)
"""Kinds of entries before which nothing needs to be known to go on."""


class Journal:
    """Writes a run's entries.

    Parameters
    ----------
    path
        The SQLite file; it must not exist yet, unless the run is resumed.
    listener
        Called with every entry after it has been written; there may be several. One that fails is not called
        again.
    resume
        Continue an existing journal.
    largest
        Size at which a file is full, bytes.
    keep
        Number of full files that are kept.

    Raises
    ------
    JournalError
        If the file exists already, or does not and should, or cannot be written.
    """

    def __init__(
        self,
        path: Path,
        listener: Listeners = None,
        *,
        resume: bool = False,
        largest: int = 100_000_000,
        keep: int = 9,
    ) -> None:
        if path.exists() and not resume:
            raise JournalError(f"{path} exists already; a run never overwrites another: name a new file")
        last = last_row(path) if resume else None
        self.path = path
        self._listeners = listeners_of(listener)
        self._largest, self._keep = largest, keep
        with self._failing_as("made"):
            self._database = open_journal(path)
        self.object: int | None = None if last is None else last[1]
        self._before = 0 if last is None else last[0]  # number of the last entry of the full files

    def append(self, content: AnyContent) -> Entry:
        """Write one entry; it is on the disk when this returns."""
        with self._failing_as("written"):
            entry = self._insert(content)
        self._notify(entry)
        return entry

    def _insert(self, content: AnyContent) -> Entry:
        time = datetime.now(UTC).isoformat()
        # SQLite numbers the entries, so that an interrupt cannot separate the number from the row.
        cursor = self._database.execute(
            "INSERT INTO entries SELECT coalesce(max(number), ?) + 1, ?, ?, ?, ? FROM entries",
            (self._before, time, content.kind, self.object, json.dumps(plain(content))),
        )
        return Entry(int(cursor.lastrowid or 0), time, self.object, content)

    def _notify(self, entry: Entry) -> None:
        """Call the listeners; one that fails, as a console that was closed, is not called again."""
        for listener in self._listeners:
            try:
                listener(entry)
            except Exception as failure:  # any exception; the run continues
                self._listeners = tuple(other for other in self._listeners if other is not listener)
                self.append(Unheard(repr(failure)))

    @property
    def full(self) -> bool:
        """Whether the entries of the file being written are to be followed by those of another."""
        (pages,), (unused,), (bytes_per_page,) = (
            self._database.execute(f"PRAGMA {what}").fetchone()
            for what in ("page_count", "freelist_count", "page_size")
        )
        return (int(pages) - int(unused)) * int(bytes_per_page) > self._largest

    @property
    def whole(self) -> bool:
        """Whether the file being written can be read without those before it."""
        return first_kind(self._database) in WHOLE

    def rotate(self, snapshot: Snapshot | MovingSnapshot) -> None:
        """Copy the entries to a numbered file, begin anew with a snapshot, and drop the oldest files.

        The file being written keeps its place, since its readers may have it open. A rotation that is cut
        short leaves either the entries in both files, and readers take them once, or nothing to be done.

        Parameters
        ----------
        snapshot
            The first entry from now on: the state of the run, for which the old files are not needed.
        """
        with self._failing_as("rotated"):
            (number,) = self._database.execute("SELECT max(number) FROM entries").fetchone()
            if number is not None:
                self._drop_oldest()
                copied(self._database, next_full_file(self.path))
                self._before = int(number)
            with transaction(self._database):
                self._database.execute("DELETE FROM entries")
                entry = self._insert(snapshot)
        self._notify(entry)

    def _drop_oldest(self) -> None:
        """Make room for one more full file; the oldest one left can be read without those dropped."""
        full = full_files(self.path)
        surplus = max(0, len(full) + 1 - self._keep)
        while surplus > 0 and not (_reads_alone(full[surplus]) if surplus < len(full) else self.whole):
            surplus -= 1
        for old in full[:surplus]:
            old.unlink()

    def close(self) -> None:
        """Close the file; everything appended is in it."""
        self._database.close()

    def __enter__(self) -> Self:
        """Use the journal as a context that closes it."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the file."""
        self.close()

    @contextmanager
    def _failing_as(self, what: str) -> Iterator[None]:
        try:
            yield
        except (sqlite3.Error, OSError) as reason:
            raise JournalNotWrittenError(
                f"the journal {self.path} cannot be {what}: {reason}; check that its folder exists and is "
                "writable and that the disk is not full"
            ) from reason


def read_journal(path: Path) -> list[Entry]:
    """Return all entries of a journal that are still kept, also of one that is being written.

    A journal of weeks takes much memory; `entries_of_journal` reads one entry after the other.

    Parameters
    ----------
    path
        The journal.sqlite of a run folder; the numbered files beside it are read too.

    Raises
    ------
    JournalError
        If the file is missing, damaged, empty, or no journal of this version.
    """
    return list(entries_of_journal(path))


def entries_of_journal(path: Path) -> Iterator[Entry]:
    """Yield what `read_journal` returns, of which only `BATCH` entries are in memory at a time."""
    if not files_of(path):
        raise _missing(path)
    entries = iterate_after(path, 0)
    first = next(entries, None)
    if first is None:
        raise _empty(path)
    yield first
    yield from entries


def entries_after(path: Path, number: int) -> list[Entry]:
    """Return the entries of a journal that follow entry `number`, in order; see `read_journal`.

    Raises
    ------
    JournalError
        If a file is damaged, or no journal of this version.
    """
    return list(iterate_after(path, number))


def iterate_after(path: Path, number: int, kinds: Sequence[str] = ()) -> Iterator[Entry]:
    """Yield what `entries_after` returns, `BATCH` entries in memory; if `kinds` are given, only those.

    The database is not read between two batches, so that a slow reader holds up neither a run nor the file's
    write-ahead log.
    """
    while (batch := _batch(path, number))[1]:
        file, rows = batch
        yield from (entry_of(file, *row) for row in rows if not kinds or row[2] in kinds)
        number = int(rows[-1][0])


def _batch(path: Path, number: int) -> tuple[Path, list[Any]]:
    """Return the next rows that follow entry `number`, and which of the files has them."""
    query = "SELECT * FROM entries WHERE number > ? ORDER BY number LIMIT ?"
    # The file being written first: entries are copied from it to a full one before they are removed here.
    newest = rows_of(path, query, number, BATCH) if path.is_file() else []
    if newest and newest[0][0] == number + 1:
        return path, newest
    for file in full_files(path):
        if (rows := rows_of(file, query, number, BATCH)) and (not newest or rows[0][0] < newest[0][0]):
            return file, rows
    return path, newest


def listeners_of(given: Listeners) -> tuple[Listener, ...]:
    """Return listeners as a tuple."""
    if given is None:
        return ()
    every = [given] if callable(given) else given
    return tuple(listener for listener in every if listener is not None)


def files_of(path: Path) -> list[Path]:
    """Return the files of a journal, oldest first."""
    return [file for file in (*full_files(path), path) if file.is_file()]


def _missing(path: Path) -> JournalError:
    return JournalError(f"{path} does not exist; name the journal.sqlite of a run folder")


def _empty(path: Path) -> JournalError:
    return JournalError(f"{path} has no entries: the run was killed before it began; start it anew")


def last_row(path: Path) -> tuple[int, int | None, str]:
    """Return number, object and time of the last entry of a journal.

    Raises
    ------
    JournalError
        As `read_journal`.
    """
    if not files_of(path):
        raise _missing(path)
    for file in reversed(files_of(path)):
        if rows := rows_of(file, "SELECT number, object, time FROM entries ORDER BY number DESC LIMIT 1"):
            return int(rows[0][0]), rows[0][1], rows[0][2]
    raise _empty(path)


def _reads_alone(file: Path) -> bool:
    """Whether a full file can be read without those before it."""
    with closing(open_to_read(file)) as database:
        return first_kind(database) in WHOLE


def entry_of(file: Path, number: int, time: str, kind: str, index: int | None, data: str) -> Entry:
    """Return the entry that a row of a file holds.

    Raises
    ------
    JournalError
        If this version does not know such an entry.
    """
    try:
        return Entry(number, time, index, content_of(kind, json.loads(data)))
    except ValueError as reason:
        raise JournalError(
            f"{file}: entry {number} ({kind}) is none that beltsort {__version__} knows: {reason}; read it "
            "with the version that wrote it, which its first entry names, or it is damaged"
        ) from reason
