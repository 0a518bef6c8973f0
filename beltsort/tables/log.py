"""Labels of scans, kept on the disk as soon as they are known.

One SQLite file. A scan is named by a key, and its labels are written once, whole or not at all: a collection
that was killed goes on where it stopped, and counts no scan twice.
"""

import json
import sqlite3
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Self, TypeAlias, TypeVar

from beltsort.errors import RecordingError
from beltsort.tables.processes import Progress, in_processes

VERSION = 1
SCHEMA = """
CREATE TABLE IF NOT EXISTS settings (name TEXT PRIMARY KEY, value TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS scans (key TEXT PRIMARY KEY, labels TEXT NOT NULL CHECK (json_valid(labels)));
"""

Labels: TypeAlias = dict[str, tuple[int | None, ...]]
"""Labels of each position, by the scan's key."""

Work = TypeVar("Work")


class LabelLog:
    """Labels by scan.

    Parameters
    ----------
    path
        The file, made if it is missing; None keeps the labels in memory only.
    settings
        What the labels depend on beside the scan: a log never mixes labels of different settings.

    Raises
    ------
    RecordingError
        If the file cannot be read or written, is no such log, or has other settings.

    Examples
    --------
    >>> log = LabelLog()
    >>> log.append({"scan 7": (1, None)})
    >>> log.append({"scan 7": (1, None), "scan 8": (0, 0)})
    >>> log.labels()
    {'scan 7': (1, None), 'scan 8': (0, 0)}
    """

    def __init__(self, path: Path | None = None, settings: Mapping[str, str] | None = None) -> None:
        self.path = path
        with self._failing_as("opened"):
            self._database = sqlite3.connect(path or ":memory:", isolation_level=None)
            self._database.execute("PRAGMA journal_mode=WAL")
            self._database.execute("PRAGMA synchronous=FULL")
            self._database.executescript(SCHEMA)
            self._check({"version": str(VERSION), **(settings or {})})

    def append(self, labels: Mapping[str, Sequence[int | None]]) -> None:
        """Write labels; all are on the disk when this returns. A key that is there keeps its labels."""
        rows = [(key, json.dumps(list(values))) for key, values in labels.items()]
        with self._failing_as("written"), self._database:
            self._database.execute("BEGIN IMMEDIATE")
            self._database.executemany("INSERT OR IGNORE INTO scans VALUES (?, ?)", rows)

    def labels(self) -> Labels:
        """Return all labels, in the order in which they were written."""
        with self._failing_as("read"):
            rows = self._database.execute("SELECT key, labels FROM scans ORDER BY rowid").fetchall()
            return {key: tuple(json.loads(labels)) for key, labels in rows}

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

    def _check(self, settings: Mapping[str, str]) -> None:
        """Write the settings into a new log, compare them with those of an old one."""
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
            raise RecordingError(
                f"the labels in {self.path} were made with {', '.join(differing)}; expected the same "
                "settings: name another output, or delete the file to begin anew"
            )

    @contextmanager
    def _failing_as(self, what: str) -> Iterator[None]:
        try:
            yield
        except (sqlite3.Error, ValueError) as reason:
            raise RecordingError(
                f"the labels in {self.path} cannot be {what}: {reason}; expected a writable file that "
                "`beltsort estimate` made: check its folder and the disk, or delete the file to begin anew"
            ) from reason


def label_missing(
    task: Callable[[Work], Labels],
    work: Sequence[Work],
    keys: Callable[[Work], Sequence[str]],
    log: LabelLog,
    workers: int | None,
    progress: Progress | None,
) -> None:
    """Label what the log does not hold yet, and append it piece by piece.

    Parameters
    ----------
    task
        Labels all scans of a piece of work.
    work
        The pieces.
    keys
        Names the scans of a piece.
    log
        Where the labels go.
    workers, progress
        As in `in_processes`.
    """
    known = log.labels().keys()
    waiting = [piece for piece in work if not known >= set(keys(piece))]
    for labels in in_processes(task, waiting, workers, progress):
        log.append(labels)
