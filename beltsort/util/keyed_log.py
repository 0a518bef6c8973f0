"""A durable key-value log for resumable work.

The log is one SQLite file. Each value is written atomically and only once, so that interrupted work can be
resumed without repeating what is done.
"""

import json
import sqlite3
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Any, ClassVar, Self

from beltsort._core import BeltsortError

VERSION = 1
ATTEMPTS = 20  # to open a file that another process is creating
SCHEMA = """
CREATE TABLE IF NOT EXISTS settings (name TEXT PRIMARY KEY, value TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS {table}
    (key TEXT PRIMARY KEY, {column} TEXT NOT NULL CHECK (json_valid({column})));
"""


class KeyedLog:
    """A log of plain data by key. Subclasses set the names used in error messages.

    Parameters
    ----------
    path
        The file, created if it is missing; None keeps the values in memory only.
    settings
        Settings on which all values depend. A log with other settings is rejected.

    Raises
    ------
    BeltsortError
        An `error`, if the file cannot be read or written, is not such a log, or has other settings.

    Examples
    --------
    >>> log = KeyedLog()
    >>> log.append({"a": [1, None]})
    >>> log.append({"a": "too late", "b": 2.5})
    >>> log.values()
    {'a': [1, None], 'b': 2.5}
    """

    table: ClassVar[str] = "entries"
    contents: ClassVar[str] = "data"
    maker: ClassVar[str] = "beltsort"
    error: ClassVar[type[BeltsortError]] = BeltsortError

    def __init__(self, path: Path | None = None, settings: Mapping[str, str] | None = None) -> None:
        self.path = path
        with self._failing_as("opened"):
            self._database = sqlite3.connect(path or ":memory:", isolation_level=None)
            self._write_ahead()
            self._database.execute("PRAGMA synchronous=FULL")
            self._database.executescript(SCHEMA.format(table=self.table, column=self.contents))
            self._check({"version": str(VERSION), **(settings or {})})

    def append(self, values: Mapping[str, Any]) -> None:
        """Write values durably. Keys that exist already keep their values."""
        rows = [(key, json.dumps(value)) for key, value in values.items()]
        with self._failing_as("written"), self._database:
            self._database.execute("BEGIN IMMEDIATE")
            self._database.executemany(f"INSERT OR IGNORE INTO {self.table} VALUES (?, ?)", rows)

    def values(self) -> dict[str, Any]:
        """Return all values by key, in the order in which they were written."""
        with self._failing_as("read"):
            rows = self._database.execute(f"SELECT * FROM {self.table} ORDER BY rowid").fetchall()
            return {key: json.loads(value) for key, value in rows}

    def close(self) -> None:
        """Close the file."""
        self._database.close()

    def __enter__(self) -> Self:
        """Use the log as a context that closes it."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the file."""
        self.close()

    def _write_ahead(self) -> None:
        """Enable the write-ahead log, waiting for another process that is creating the file.

        Transactions wait for a lock until the timeout of `sqlite3.connect`; this pragma does not, so the wait
        is an empty transaction.
        """
        for _ in range(ATTEMPTS):
            try:
                self._database.execute("PRAGMA journal_mode=WAL")
                return
            except sqlite3.OperationalError as reason:
                if reason.sqlite_errorcode != sqlite3.SQLITE_BUSY:
                    raise
            self._database.execute("BEGIN IMMEDIATE")
            self._database.execute("COMMIT")
        raise sqlite3.OperationalError("it is locked by another process")

    def _check(self, settings: Mapping[str, str]) -> None:
        """Write the settings to a new log, or compare them with those of an existing one."""
        rows = list(settings.items())
        with self._database:
            self._database.execute("BEGIN IMMEDIATE")
            kept = dict(self._database.execute("SELECT name, value FROM settings").fetchall())
            if not kept:
                self._database.executemany("INSERT INTO settings VALUES (?, ?)", rows)
        differing = sorted(
            f"{name} {kept.get(name)} (now: {settings.get(name)})"
            for name in kept.keys() | settings.keys()
            if kept and kept.get(name) != settings.get(name)
        )
        if differing:
            raise self.error(
                f"the {self.contents} in {self.path} were made with {', '.join(differing)}; expected "
                "the same settings: name another output, or delete the file to begin anew"
            )

    @contextmanager
    def _failing_as(self, what: str) -> Iterator[None]:
        try:
            yield
        except (sqlite3.Error, ValueError) as reason:
            raise self.error(
                f"the {self.contents} in {self.path} cannot be {what}: {reason}; expected a writable file "
                f"that {self.maker} made: check its folder and the disk, or delete the file to begin anew"
            ) from reason
