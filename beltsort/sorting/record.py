"""Writing down, then taking in: the only way in which a run's state changes."""

from pathlib import Path

from beltsort.sorting.entries import AnyContent
from beltsort.sorting.journal import Journal, read_journal
from beltsort.sorting.progress import Progress


class Record:
    """A journal, and the progress that follows from it.

    Parameters
    ----------
    journal
        Open.
    progress
        As far as the journal goes.
    """

    def __init__(self, journal: Journal, progress: Progress) -> None:
        self.journal, self.progress = journal, progress

    def __call__(self, content: AnyContent) -> None:
        """Write an entry, then take it in."""
        self.progress.apply(self.journal.append(content))
        self.journal.object = self.progress.index
        if self.journal.full:
            self.journal.rotate(self.progress.snapshot())


def progress_in(path: Path) -> Progress:
    """Return how far the run of a journal has come.

    Raises
    ------
    JournalError
        If the journal is missing or damaged, or begins in the middle of nowhere.
    """
    return Progress.after(read_journal(path))
