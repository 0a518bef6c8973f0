"""The SQLite files of a journal: their names, their schema, and how they are opened."""

import os
import sqlite3
import warnings
from collections.abc import Iterator
from contextlib import closing, contextmanager, suppress
from pathlib import Path
from typing import Any

from beltsort.errors import JournalError
from beltsort.util.filesystems import file_system_of, on_network

JOURNAL = "journal.sqlite"
"""The file that is being written, in the folder of a run."""
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
BUSY_SECONDS = 30.0
"""How long a writer waits for a reader. Readers delay it on network disks only."""

WRITE_AHEAD = b"\x02\x02"
"""Bytes 18 and 19 of an SQLite file that is written with a write-ahead log."""


class NetworkDiskWarning(UserWarning):
    """A journal is written to a disk of another machine."""


def open_journal(path: Path) -> sqlite3.Connection:
    """Open a journal for writing, and make it if need be; what is committed is on the disk.

    A write-ahead log needs memory that all processes share, which processes on several machines do not have;
    on a network disk there is a rollback journal instead, and a warning.
    """
    network = on_network(path.parent)
    if network:
        warnings.warn(
            f"{path} is on a network disk ({file_system_of(path.parent)}): entries take longer, no other "
            "machine may read it during the run, and the run ends when the network does; work in a folder "
            "on a local disk",
            NetworkDiskWarning,
            stacklevel=2,
        )
    database = sqlite3.connect(path, isolation_level=None, timeout=BUSY_SECONDS)
    try:
        database.execute(f"PRAGMA journal_mode={'TRUNCATE' if network else 'WAL'}")
        database.execute("PRAGMA synchronous=FULL")
        if database.execute("SELECT count(*) FROM sqlite_schema").fetchone() == (0,):
            with transaction(database):
                database.execute(SCHEMA)
                database.execute(f"PRAGMA user_version={VERSION}")
    except BaseException:
        database.close()
        raise
    return database


@contextmanager
def transaction(database: sqlite3.Connection) -> Iterator[None]:
    """Commit what the block does as a whole; nothing of it if it fails or is interrupted."""
    database.execute("BEGIN IMMEDIATE")
    try:
        yield
    except BaseException:
        database.execute("ROLLBACK")
        raise
    database.execute("COMMIT")


def open_to_read(file: Path) -> sqlite3.Connection:
    """Open a file so that nothing is written or left behind, even by a reader that is killed.

    With a write-ahead log that is not beside it, no run has the file open. SQLite would then make one in
    order to read, and could not remove it; it does not if it is told that the file does not change. Without
    one, only what a killed run has left of a rollback journal makes it necessary to write.
    """
    options = "mode=ro"
    if _has_write_ahead_log(file):
        if not file.with_name(f"{file.name}-wal").exists():
            options = "mode=ro&immutable=1"
    elif _is_filled(file.with_name(f"{file.name}-journal")):
        options = "mode=rw"
    return sqlite3.connect(f"{file.absolute().as_uri()}?{options}", uri=True, timeout=BUSY_SECONDS)


def first_kind(database: sqlite3.Connection) -> str | None:
    """Return the kind of the first entry; None if there are none."""
    row = database.execute("SELECT kind FROM entries ORDER BY number LIMIT 1").fetchone()
    return None if row is None else str(row[0])


def rows_of(file: Path, query: str, *values: int | str) -> list[Any]:
    """Return the rows of a query; none of a file whose table was not made before a kill.

    Raises
    ------
    JournalError
        If the file is damaged, or no journal of this version.
    """
    try:
        with closing(open_to_read(file)) as database:
            (version,) = database.execute("PRAGMA user_version").fetchone()
            if version == 0 and database.execute("SELECT count(*) FROM sqlite_schema").fetchone() == (0,):
                return []
            if version != VERSION:
                raise JournalError(_other_version(file, int(version)))
            return database.execute(query, values).fetchall()
    except (sqlite3.Error, ValueError) as reason:
        raise JournalError(f"{file} cannot be read as a journal: {reason}") from reason


def _other_version(file: Path, version: int) -> str:
    remedy = f": `beltsort migrate {file.parent}` makes one of it" if version == 1 else ""
    return f"{file} is no journal of version {VERSION} (found {version}){remedy}"


def copied(database: sqlite3.Connection, copy: Path) -> None:
    """Copy a database, which may be in use, to a new file that is on the disk when this returns."""
    part = copy.with_name(f"{copy.name}.part")
    part.unlink(missing_ok=True)  # of a copy that was cut short
    with closing(sqlite3.connect(part, isolation_level=None)) as target:
        database.backup(target)
        target.execute("PRAGMA journal_mode=DELETE")  # nothing beside it, wherever it is moved
    replaced(part, copy)


def replaced(part: Path, file: Path) -> None:
    """Give a file that was written whole its name; both are on the disk when this returns."""
    _synchronise(part)
    part.replace(file)
    with suppress(OSError):  # some network disks know no such thing
        _synchronise(file.parent)


def _synchronise(path: Path) -> None:
    number = os.open(path, os.O_RDONLY)
    try:
        os.fsync(number)
    finally:
        os.close(number)


def full_files(path: Path) -> list[Path]:
    """Return the full files beside the one being written, oldest first."""
    return sorted(path.parent.glob(f"{path.stem}-[0-9][0-9][0-9][0-9]{path.suffix}"))


def journal_bytes(folder: Path) -> int:
    """Return the size of the files of a run's journal, bytes."""
    size = 0
    for file in folder.glob(f"{Path(JOURNAL).stem}*"):
        with suppress(OSError):  # dropped meanwhile
            size += file.stat().st_size
    return size


def next_full_file(path: Path) -> Path:
    """Return the path for the next full file beside the one being written."""
    full = full_files(path)
    latest = int(full[-1].stem.rpartition("-")[2]) if full else 0
    return path.with_name(f"{path.stem}-{latest + 1:04}{path.suffix}")


def _has_write_ahead_log(file: Path) -> bool:
    try:
        with file.open("rb") as content:
            return content.read(20)[18:] == WRITE_AHEAD
    except OSError:
        return False


def _is_filled(file: Path) -> bool:
    try:
        return file.stat().st_size > 0
    except OSError:
        return False
