"""The durable record of a run.

An append-only list of entries in one SQLite file. Every entry is on the disk before the call that wrote it
returns (WAL, synchronous=FULL), so that what the cell did can be told after any crash: an *intent* without
its *outcome* is the one command whose fate is unknown.
"""

import json
import sqlite3
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from beltsort.errors import JournalError

VERSION = 1
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
    kind
        `start`, `plan`, `intent`, `outcome`, `scan`, `drift`, `bad_scan`, `decision`, `skip` or `end`.
    object
        Number of the object at the belt end; None before the first.
    data
        What the kind tells, as plain JSON.
    """

    number: int
    time: str
    kind: str
    object: int | None
    data: dict[str, Any]


Listener = Callable[[Entry], None]


class Journal:
    """Writes a run's entries to a new file.

    Parameters
    ----------
    path
        The SQLite file; it must not exist yet.
    listener
        Called with every entry after it has been written.

    Raises
    ------
    JournalError
        If the file exists already or cannot be written.
    """

    def __init__(self, path: Path, listener: Listener | None = None) -> None:
        if path.exists():
            raise JournalError(f"{path} exists already; a run never overwrites another: name a new file")
        self.path = path
        self.object: int | None = None
        self._listener = listener
        self._commands = 0
        with self._failing_as("made"):
            self._database = sqlite3.connect(path, isolation_level=None)
            self._database.execute("PRAGMA journal_mode=WAL")
            self._database.execute("PRAGMA synchronous=FULL")
            self._database.execute(SCHEMA)
            self._database.execute(f"PRAGMA user_version={VERSION}")

    def append(self, kind: str, **data: Any) -> Entry:
        """Write one entry; it is on the disk when this returns."""
        time = datetime.now(UTC).isoformat()
        with self._failing_as("written"):
            # SQLite numbers the entries: an interrupt cannot part its count from what is written.
            cursor = self._database.execute(
                "INSERT INTO entries (time, kind, object, data) VALUES (?, ?, ?, ?)",
                (time, kind, self.object, json.dumps(data)),
            )
        entry = Entry(int(cursor.lastrowid or 0), time, kind, self.object, data)
        if self._listener:
            self._listener(entry)
        return entry

    @contextmanager
    def command(self, name: str, **target: Any) -> Iterator[str]:
        """Frame an actuator command by its intent and its outcome; the value is the command's id.

        The id is unique in the run; whoever repeats the command repeats the id.
        """
        self._commands += 1
        command_id = f"{name}-{self._commands}"
        self.append("intent", command_id=command_id, command=name, **target)
        try:
            yield command_id
        except BaseException as failure:
            self.append("outcome", command_id=command_id, done=False, error=repr(failure))
            raise
        self.append("outcome", command_id=command_id, done=True)

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
        except sqlite3.Error as reason:
            raise JournalError(
                f"the journal {self.path} cannot be {what}: {reason}; check that its folder exists and is "
                "writable and that the disk is not full"
            ) from reason


def read_journal(path: Path) -> list[Entry]:
    """Return all entries of a journal, also of one that is still being written.

    Raises
    ------
    JournalError
        If the file is missing, damaged, or no journal of this version.
    """
    if not path.is_file():
        raise JournalError(f"{path} does not exist; name the journal.sqlite of a run folder")
    try:
        database = sqlite3.connect(path)
        try:
            (version,) = database.execute("PRAGMA user_version").fetchone()
            if version != VERSION:
                raise JournalError(f"{path} is no journal of version {VERSION} (found {version})")
            rows = database.execute("SELECT * FROM entries ORDER BY number").fetchall()
        finally:
            database.close()
        return [Entry(number, time, kind, obj, json.loads(data)) for number, time, kind, obj, data in rows]
    except (sqlite3.Error, ValueError) as reason:
        raise JournalError(f"{path} cannot be read as a journal: {reason}") from reason
