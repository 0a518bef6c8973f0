"""Writing an entry and applying it to the state: the only way in which a run's state changes."""

from pathlib import Path
from typing import Self

from beltsort.sorting.entries import AnyContent
from beltsort.sorting.journal import Entry, Journal, read_journal
from beltsort.sorting.progress import Progress


class Record:
    """A journal, and the state of the run after its entries.

    Parameters
    ----------
    journal
        The open journal.
    progress
        The state after its last entry.
    """

    def __init__(self, journal: Journal, progress: Progress) -> None:
        self.journal, self.progress = journal, progress

    @classmethod
    def resumed(cls, journal: Journal) -> Self:
        """Return the record of a run that is resumed.

        Raises
        ------
        JournalError
            As `progress_in`.
        """
        record = cls(journal, progress_in(journal.path))
        if not journal.whole:  # an earlier version was killed between two files
            journal.rotate(record.progress.snapshot())
        return record

    def __call__(self, content: AnyContent) -> Entry:
        """Write an entry, apply it to the state, and return it."""
        entry = self.journal.append(content)
        self.progress.apply(entry)
        self.journal.object = self.progress.index
        if self.journal.full:
            self.journal.rotate(self.progress.snapshot())
        return entry


def progress_in(path: Path) -> Progress:
    """Return the state of the run after the last entry of a journal.

    Raises
    ------
    JournalError
        If the journal is missing or damaged, or begins with neither a start nor a snapshot.
    """
    return Progress.after(read_journal(path))
