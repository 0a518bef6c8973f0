"""Writing an entry and applying it to the state: the only way in which a run's state changes."""

from dataclasses import replace
from itertools import chain
from pathlib import Path
from typing import Self

from beltsort.sorting.entries import AnyContent, Decided, Skipped, Snapshot
from beltsort.sorting.journal import Entry, Journal
from beltsort.sorting.journal_queries import entries_before, newest_entries
from beltsort.sorting.progress import Progress, decision_of
from beltsort.sorting.report import Counts, Decision
from beltsort.sorting.run_state import LATEST


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
    long, only the latest decisions and empty cups are read, or all of them if a version of beltsort whose
    snapshots have no counts wrote it.

    Raises
    ------
    JournalError
        If the journal is missing or damaged, or begins with neither a start nor a snapshot.
    """
    following = newest_entries(path)
    first = next(following)
    progress = Progress.after(chain([first], following))
    passed = set(progress.passed)
    begins = progress.decisions[0].object if progress.decisions else None
    decisions: list[Decision] = []
    skipped: list[int] = []
    counts = Counts.none(progress.model)
    counted = not isinstance(first.content, Snapshot) or first.content.counts is not None
    for entry in entries_before(path, first.number, (Decided.kind, Skipped.kind)):
        match entry.object, entry.content:
            case int(index), Decided() as decided if index not in passed and index != begins:
                decisions.append(decision_of(index, decided))
                counts = counts if counted else counts.with_decision(decisions[-1], progress.model)
            case int(index), Skipped():
                skipped.append(index)
                counts = counts if counted else replace(counts, skipped=counts.skipped + 1)
        if counted and len(decisions) + len(skipped) >= LATEST:
            break
    progress.decisions[:0], progress.skipped[:0] = decisions[::-1], skipped[::-1]
    del progress.decisions[:-LATEST], progress.skipped[:-LATEST]
    if not counted:
        progress.counts = progress.counts.added(counts)
    return progress
