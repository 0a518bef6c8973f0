"""The durable record of a run.

An append-only list of entries in SQLite files. Every entry is on the disk before the call that wrote it
returns (WAL, synchronous=FULL), so that the cell's actions are known after any crash, except for the outcome
of one command: the *intent* that no *outcome* follows.

A long run is kept in several files, of which the oldest are dropped: `journal.sqlite` is being written, the
full ones beside it are numbered (`journal-0001.sqlite`).
"""

import json
import sqlite3
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from beltsort._core import __version__
from beltsort.errors import JournalError, JournalNotWrittenError
from beltsort.sorting.entries import AnyContent, Snapshot, Unheard
from beltsort.sorting.entry_format import content_of, plain

VERSION = 2
SCHEMA = """
CREATE TABLE entries (
    number INTEGER PRIMARY KEY,
    time TEXT NOT NULL,
    kind TEXT NOT NULL,
    object INTEGER,
    data TEXT NOT NULL CHECK (json_valid(data))
)
"""


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


class Journal:
    """Writes a run's entries.

    Parameters
    ----------
    path
        The SQLite file; it must not exist yet, unless the run is resumed.
    listener
        Called with every entry after it has been written.
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
        listener: Listener | None = None,
        *,
        resume: bool = False,
        largest: int = 100_000_000,
        keep: int = 9,
    ) -> None:
        if path.exists() and not resume:
            raise JournalError(f"{path} exists already; a run never overwrites another: name a new file")
        last = read_journal(path)[-1] if resume else None
        self.path = path
        self.object: int | None = None if last is None else last.object
        self._listener = listener
        self._largest, self._keep = largest, keep
        self._before = 0 if last is None else last.number  # number of the last entry of the full files
        self._database = self._opened()

    def append(self, content: AnyContent) -> Entry:
        """Write one entry; it is on the disk when this returns."""
        time = datetime.now(UTC).isoformat()
        with self._failing_as("written"):
            # SQLite numbers the entries, so that an interrupt cannot separate the number from the row.
            cursor = self._database.execute(
                "INSERT INTO entries SELECT coalesce(max(number), ?) + 1, ?, ?, ?, ? FROM entries",
                (self._before, time, content.kind, self.object, json.dumps(plain(content))),
            )
        entry = Entry(int(cursor.lastrowid or 0), time, self.object, content)
        if self._listener:
            self._notify(self._listener, entry)
        return entry

    def _notify(self, listener: Listener, entry: Entry) -> None:
        """Call the listener; one that fails, as a console that was closed, is not called again."""
        try:
            listener(entry)
        except Exception as failure:  # any exception; the run continues
            self._listener = None
            self.append(Unheard(repr(failure)))

    @property
    def full(self) -> bool:
        """Whether the file being written is to be followed by another."""
        (pages,), (bytes_per_page,) = (
            self._database.execute(f"PRAGMA {what}").fetchone() for what in ("page_count", "page_size")
        )
        return int(pages) * int(bytes_per_page) > self._largest

    def rotate(self, snapshot: Snapshot) -> None:
        """Begin a new file, and drop the oldest.

        Parameters
        ----------
        snapshot
            The first entry of the new file: the state of the run, for which the old files are not needed.
        """
        (number,) = self._database.execute("SELECT max(number) FROM entries").fetchone()
        full = _full_files(self.path)
        with self._failing_as("rotated"):
            self._database.execute("PRAGMA wal_checkpoint(TRUNCATE)")
            self._database.close()
            latest = int(full[-1].stem.rpartition("-")[2]) if full else 0
            self.path.rename(_full_file(self.path, latest + 1))
            self._before = int(number)
            self._database = self._opened()
            self.append(snapshot)
            for old in full[: max(0, len(full) + 1 - self._keep)]:
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

    def _opened(self) -> sqlite3.Connection:
        """Open the file, and make it if need be."""
        with self._failing_as("made"):
            database = sqlite3.connect(self.path, isolation_level=None)
            database.execute("PRAGMA journal_mode=WAL")
            database.execute("PRAGMA synchronous=FULL")
            if database.execute("SELECT count(*) FROM sqlite_schema").fetchone() == (0,):
                database.execute("BEGIN")
                database.execute(SCHEMA)
                database.execute(f"PRAGMA user_version={VERSION}")
                database.execute("COMMIT")
        return database

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

    Parameters
    ----------
    path
        The journal.sqlite of a run folder; the numbered files beside it are read too.

    Raises
    ------
    JournalError
        If the file is missing, damaged, empty, or no journal of this version.
    """
    files = [file for file in (*_full_files(path), path) if file.is_file()]
    if not files:
        raise JournalError(f"{path} does not exist; name the journal.sqlite of a run folder")
    entries = entries_after(path, 0)
    if not entries:
        raise JournalError(f"{path} has no entries: the run was killed before it began; start it anew")
    return entries


def entries_after(path: Path, number: int) -> list[Entry]:
    """Return the entries of a journal that follow entry `number`, in order; see `read_journal`.

    Raises
    ------
    JournalError
        If a file is damaged, or no journal of this version.
    """
    files = [file for file in (*_full_files(path), path) if file.is_file()]
    return [entry for file in files for entry in _read_file(file, number)]


def _read_only(file: Path) -> sqlite3.Connection:
    """Open a file so that nothing is written or left behind, even by a reader that is killed.

    Without a write-ahead log beside it, no run has the file open. SQLite would then make one in order to
    read, and could not remove it; it does not if it is told that the file does not change.
    """
    unused = not file.with_name(f"{file.name}-wal").exists()
    address = f"{file.absolute().as_uri()}?mode=ro{'&immutable=1' if unused else ''}"
    return sqlite3.connect(address, uri=True)


def _read_file(file: Path, after: int) -> list[Entry]:
    try:
        with closing(_read_only(file)) as database:
            (version,) = database.execute("PRAGMA user_version").fetchone()
            if version == 0 and database.execute("SELECT count(*) FROM sqlite_schema").fetchone() == (0,):
                return []
            if version != VERSION:
                raise JournalError(f"{file} is no journal of version {VERSION} (found {version})")
            rows = database.execute(
                "SELECT * FROM entries WHERE number > ? ORDER BY number", (after,)
            ).fetchall()
    except (sqlite3.Error, ValueError) as reason:
        raise JournalError(f"{file} cannot be read as a journal: {reason}") from reason
    return [_entry(file, *row) for row in rows]


def _entry(file: Path, number: int, time: str, kind: str, index: int | None, data: str) -> Entry:
    try:
        return Entry(number, time, index, content_of(kind, json.loads(data)))
    except ValueError as reason:
        raise JournalError(
            f"{file}: entry {number} ({kind}) is none that beltsort {__version__} knows: {reason}; read it "
            "with the version that wrote it, which its first entry names, or it is damaged"
        ) from reason


def _full_files(path: Path) -> list[Path]:
    """Return the full files beside the one being written, oldest first."""
    return sorted(path.parent.glob(f"{path.stem}-[0-9][0-9][0-9][0-9]{path.suffix}"))


def _full_file(path: Path, number: int) -> Path:
    return path.with_name(f"{path.stem}-{number:04}{path.suffix}")
