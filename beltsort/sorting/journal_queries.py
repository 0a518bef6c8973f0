"""What parts of a journal are read for: none of them needs all entries."""

from collections.abc import Iterator, Sequence
from pathlib import Path

from beltsort.sorting.journal import (
    BATCH,
    WHOLE,
    Entry,
    entries_of_journal,
    entry_of,
    files_of,
    iterate_after,
)
from beltsort.sorting.journal_files import full_files, rows_of


def has_entries(path: Path) -> bool:
    """Return whether a journal has any entry that is still kept; one that does not exist has none.

    Raises
    ------
    JournalError
        If a file is damaged, or no journal of this version.
    """
    return any(rows_of(file, "SELECT 1 FROM entries LIMIT 1") for file in files_of(path))


def kind_of_first(path: Path) -> str | None:
    """Return the kind of the first entry of a journal that is still kept; None if there is none.

    Raises
    ------
    JournalError
        If a file is damaged, or no journal of this version.
    """
    query = "SELECT number, kind FROM entries ORDER BY number LIMIT 1"
    first = [row for file in files_of(path) for row in rows_of(file, query)]
    return min(first)[1] if first else None


def newest_entries(path: Path) -> Iterator[Entry]:
    """Yield the entries from the last start or snapshot on that begins a file; see `read_journal`."""
    query = "SELECT number, kind FROM entries ORDER BY number LIMIT 1"
    rows = rows_of(path, query) if path.is_file() else []
    if rows and rows[0][1] in WHOLE:
        return iterate_after(path, int(rows[0][0]) - 1)
    return entries_of_journal(path)


def entries_before(path: Path, number: int, kinds: Sequence[str]) -> Iterator[Entry]:
    """Yield the entries of some kinds before entry `number` in the full files, the latest first."""
    known = ", ".join("?" * len(kinds))
    query = f"SELECT * FROM entries WHERE number < ? AND kind IN ({known}) ORDER BY number DESC LIMIT {BATCH}"
    for file in reversed(full_files(path)):
        while rows := rows_of(file, query, number, *kinds):
            yield from (entry_of(file, *row) for row in rows)
            number = int(rows[-1][0])


def entries_since(path: Path, kind: str, kinds: Sequence[str]) -> Iterator[Entry]:
    """Yield the entries of some kinds from the last one of `kind` on; if there is none, from the first."""
    query = "SELECT number FROM entries WHERE kind = ? ORDER BY number DESC LIMIT 1"
    for file in reversed(files_of(path)):
        if rows := rows_of(file, query, kind):
            return iterate_after(path, int(rows[0][0]) - 1, kinds)
    return iterate_after(path, 0, kinds)
