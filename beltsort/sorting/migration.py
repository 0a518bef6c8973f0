"""Journals of version 1 made into such of today's version.

Version 1 had no names of runs, attempts or states, and wrote a decision after its sort; today it comes first.
"""

import json
import sqlite3
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

from beltsort import SortingModel
from beltsort.cell.commands import Outcome
from beltsort.errors import JournalError, JournalNotWrittenError
from beltsort.sorting.entry_format import content_of
from beltsort.sorting.journal import Entry, read_journal
from beltsort.sorting.journal_files import SCHEMA, VERSION, open_to_read, replaced, transaction
from beltsort.sorting.progress import Progress
from beltsort.sorting.runs import journal_of

OLD = 1
RUN = "version1"
"""The name of a run that had none."""
TARGETS = {"move": "viewpoint", "sort": "label", "advance": "index"}
"""The field of an intent's target, by its command."""

Fields: TypeAlias = dict[str, Any]  # of an entry, as JSON has them


@dataclass(frozen=True)
class Row:
    """A row of the table of entries, without its number."""

    time: str
    kind: str
    object: int | None
    data: Fields


@dataclass(frozen=True)
class Migrated:
    """What became of a journal.

    Attributes
    ----------
    path
        The journal.
    kept
        The old one; None if it was of today's version already.
    entries
        Number of its entries.
    notes
        What the old one did not record, and what was left out.
    """

    path: Path
    kept: Path | None
    entries: int
    notes: tuple[str, ...] = ()


def migrate(run: Path) -> Migrated:
    """Make the journal of a run one of today's version, and keep the old one beside it.

    Parameters
    ----------
    run
        As in `beltsort.sorting.audit.journal_of`.

    Raises
    ------
    JournalError
        If there is no journal, it cannot be read, or is of a version that cannot be migrated.
    JournalNotWrittenError
        If the new one cannot be written.
    """
    path = journal_of(run)
    kept = path.with_name(f"{path.name}.version-{OLD}")
    source = kept if kept.exists() and not path.exists() else path  # cut short between two names
    if not source.exists():
        raise JournalError(f"{path} does not exist; name the journal.sqlite of a run folder")
    version = _version_of(source)
    if version == VERSION:
        return Migrated(path, None, len(read_journal(path)))
    if version != OLD:
        raise JournalError(
            f"{source} is of version {version}, expected {OLD} or {VERSION}: read it with the version of "
            "beltsort that wrote it"
        )
    old = _rows_of(source)
    if not old or old[0].kind != "start":
        raise JournalError(f"{source} does not begin with 'start', so that nothing can be migrated")
    notes: list[str] = []
    rows = list(_converted(old, notes))
    _check(rows, path)
    part = path.with_name(f"{path.name}.part")
    try:
        _write(rows, part)
        if source is path:
            _closed(path).rename(kept)
        replaced(part, path)
    except (OSError, sqlite3.Error) as reason:
        raise JournalNotWrittenError(
            f"{path} cannot be migrated: {reason}; check that its folder is writable and that the disk is "
            "not full"
        ) from reason
    return Migrated(path, kept, len(rows), tuple(notes))


def _version_of(file: Path) -> int:
    try:
        with closing(open_to_read(file)) as database:
            (version,) = database.execute("PRAGMA user_version").fetchone()
    except sqlite3.Error as reason:
        raise JournalError(f"{file} cannot be read as a journal: {reason}") from reason
    return int(version)


def _rows_of(file: Path) -> list[Row]:
    try:
        with closing(open_to_read(file)) as database:
            found = database.execute(
                "SELECT time, kind, object, data FROM entries ORDER BY number"
            ).fetchall()
        return [Row(time, kind, index, json.loads(data)) for time, kind, index, data in found]
    except (sqlite3.Error, ValueError) as reason:
        raise JournalError(f"{file} cannot be read as a journal: {reason}") from reason


def _converted(old: list[Row], notes: list[str]) -> Iterator[Row]:
    """Yield the rows of today's version."""
    notes.append("durations of plans were not recorded: they are 0")
    notes.append("what perception found at a position was recorded only as empty or not")
    decisions = iter([row for row in old if row.kind == "decision"])
    nothing = _nothing_remembered(SortingModel.from_json(old[0].data["model"]))
    by_policy = False  # whether the last plan chose a decision
    for number, row in enumerate(old):
        if row.kind == "decision":
            continue  # with its sort
        if row.kind == "plan":
            by_policy = "decide" in row.data["action"]
        if row.kind == "intent" and row.data["command"] == "sort":
            decision = next(decisions, None)
            if decision is None:
                notes.append(f"object {row.object}: the sort that was interrupted, and how, were left out")
                yield from (row for row in old[number:] if row.kind == "end")
                return
            yield Row(row.time, "decision", row.object, {**decision.data, "bin": row.data["label"]})
        data = _data_of(row, arriving=number == 1, decided=by_policy, nothing=nothing)
        yield Row(row.time, row.kind, row.object, data)


def _data_of(row: Row, *, arriving: bool, decided: bool, nothing: list[list[int]]) -> Fields:
    """Return the fields of an entry in today's version.

    Parameters
    ----------
    row
        The entry.
    arriving
        Whether it is the move with which a run began.
    decided
        Whether the last plan was a decision.
    nothing
        The last labels if none is remembered.
    """
    data = row.data
    match row.kind:
        case "start":
            return {"run": RUN, **data}
        case "intent":
            name, target = data["command"], data[TARGETS[data["command"]]]
            command = {"id": data["command_id"], "name": name, "target": target, "boot_id": ""}
            return {"command": {**command, "arriving": arriving}}
        case "outcome" if data["done"]:
            return {"command_id": data["command_id"]}
        case "outcome":
            unknown = Outcome.UNKNOWN.value
            return {"command_id": data["command_id"], "outcome": unknown, "error": data["error"]}
        case "plan" if "values" in data:
            return {"seconds": 0.0, **data}
        case "scan":
            return {"findings": _findings(data["empty"]), "last_labels": nothing, **data}
        case "bad_scan":
            return {"error": data["error"]}
        case "skip":
            return {"viewpoints": data["viewpoints"], "decided": decided}
    return data


def _findings(empty: list[bool]) -> list[str]:
    return ["empty" if each else "object" for each in empty]


def _nothing_remembered(model: SortingModel) -> list[list[int]]:
    """Return the last labels, shape (H, K), of scans that did not record them."""
    return [[-1] * len(model.viewpoints) for _ in range(model.positions)]


def _check(rows: list[Row], path: Path) -> None:
    """Compute the state of the run from the new rows."""
    try:
        contents = [(row, content_of(row.kind, row.data)) for row in rows]
        Progress.after(
            [Entry(n, row.time, row.object, content) for n, (row, content) in enumerate(contents, 1)]
        )
    except (JournalError, ValueError, KeyError, IndexError) as reason:
        raise JournalError(
            f"{path} cannot be migrated, and is as it was: {reason}; read it with the version of beltsort "
            "that wrote it"
        ) from reason


def _write(rows: list[Row], part: Path) -> None:
    part.unlink(missing_ok=True)
    with closing(sqlite3.connect(part, isolation_level=None)) as database, transaction(database):
        database.execute(SCHEMA)
        database.execute(f"PRAGMA user_version={VERSION}")
        database.executemany(
            "INSERT INTO entries (time, kind, object, data) VALUES (?, ?, ?, ?)",
            [(row.time, row.kind, row.object, json.dumps(row.data)) for row in rows],
        )


def _closed(path: Path) -> Path:
    """Move what a killed run has left in the write-ahead log into the file, so that it can be renamed."""
    with closing(sqlite3.connect(path, isolation_level=None)) as database:
        database.execute("PRAGMA journal_mode=DELETE")
    return path
