"""Writing an entry and applying it to the state: the only way in which a run's state changes."""

from pathlib import Path
from typing import Self

from beltsort.sorting.entries import AnyContent, Decided, Skipped
from beltsort.sorting.journal import Entry, Journal, entries_before, newest_entries
from beltsort.sorting.progress import Progress
from beltsort.sorting.report import Decision


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

    Of a journal of several files, the newest one has the state; of the others, which may be many times as
    long, only the decisions and the empty cups are read.

    Raises
    ------
    JournalError
        If the journal is missing or damaged, or begins with neither a start nor a snapshot.
    """
    entries = newest_entries(path)
    progress = Progress.after(entries)
    earlier = entries_before(path, entries[0].number, (Decided.kind, Skipped.kind))
    decisions, skipped, passed = [], [], set(progress.passed)
    for entry in earlier:
        match entry.object, entry.content:
            case int(index), Decided() as decided if index not in passed:
                found = Decision(index, decided.label, decided.belief, decided.looks, decided.forced)
                decisions.append(found)
            case int(index), Skipped():
                skipped.append(index)
    progress.decisions[:0], progress.skipped[:0] = decisions, skipped
    return progress
