"""Reading the journal of a run on a belt that never stops."""

from pathlib import Path

from beltsort.sorting.journal_queries import entries_since, kind_of_first, newest_entries
from beltsort.sorting.moving.entries import Looked, MovingSnapshot, MovingStarted
from beltsort.sorting.moving.state import MovingState


def is_moving(path: Path) -> bool:
    """Return whether a journal is of a run on a belt that never stops; not if it has no entries.

    Raises
    ------
    JournalError
        If a file is damaged, or no journal of this version.
    """
    return kind_of_first(path) in (MovingStarted.kind, MovingSnapshot.kind)


def moving_state_in(path: Path) -> MovingState:
    """Return the state of a run after the last entry of its journal.

    Raises
    ------
    JournalError
        If the journal is missing or damaged, or of a belt that stops.
    """
    return MovingState.after(newest_entries(path))


def last_look(path: Path) -> Looked | None:
    """Return the last scan of a run; None if there is none.

    Raises
    ------
    JournalError
        If a file is damaged, or no journal of this version.
    """
    for entry in entries_since(path, Looked.kind, (Looked.kind,)):
        if isinstance(entry.content, Looked):
            return entry.content
    return None
