"""Removal of old runs: which may go, and why others stay."""

import shutil
import warnings
from collections import Counter
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path

from beltsort._core import ArgumentError
from beltsort.cell.commands import SortInto
from beltsort.errors import InUseError, JournalError
from beltsort.sorting.journal_files import JOURNAL
from beltsort.sorting.journal_queries import has_entries
from beltsort.sorting.locks import holder_of, in_use, locked
from beltsort.sorting.moving.reading import is_moving, moving_state_in
from beltsort.sorting.record import progress_in
from beltsort.sorting.runs import DRY_RUN, LOCK, REMOVED, cell_file_of
from beltsort.sorting.status import Condition, status_of


@dataclass(frozen=True)
class KeptRun:
    """A run that stays.

    Attributes
    ----------
    folder
        The run's.
    why
        Why it stays.
    """

    folder: Path
    why: str


@dataclass(frozen=True)
class OldRun:
    """A run that may be removed.

    Attributes
    ----------
    folder
        The run's.
    updated
        When its journal was last written, or its folder if it has none; UTC.
    size
        Size of all files in the folder, bytes.
    """

    folder: Path
    updated: datetime
    size: int


@dataclass(frozen=True)
class Pruning:
    """What is removed from a folder of runs, and what is not; the oldest first.

    Attributes
    ----------
    old
        Runs that may be removed, or have been.
    kept
        Runs that stay.
    """

    old: tuple[OldRun, ...]
    kept: tuple[KeptRun, ...]

    @property
    def size(self) -> int:
        """Size of all files of the runs in `old`, bytes."""
        return sum(run.size for run in self.old)


def old_runs(
    runs: Path, *, keep: int = 1, older_than: timedelta | None = None, cell: Path | None = None
) -> Pruning:
    """Return which runs may be removed; nothing is changed.

    A run stays if it is among the newest of its cell, is newer than asked, is in use, is held, was killed
    during a sort whose outcome nobody has established, or has a journal that cannot be read. The newest run
    of a cell always stays, since it is the one that `--resume latest` and `--service` look at: without it
    they would find an older one, after which the belt has moved on.

    Parameters
    ----------
    runs
        Folder of runs.
    keep
        Number of the newest runs of each cell that stay, at least 1; dry runs are counted apart. A run that
        ended before its first entry is not counted, and goes once as many newer ones have begun.
    older_than
        Only runs whose journal was last written longer ago are removed; by default the age does not matter.
    cell
        Cell file whose runs alone are considered; None: those of all cells.

    Raises
    ------
    ArgumentError
        If `keep` is less than 1, `older_than` is negative, or `runs` is a run and not a folder of runs.
    """
    _check(runs, keep, older_than)
    latest = None if older_than is None else datetime.now(UTC) - older_than
    newer: Counter[tuple[Path | None, bool]] = Counter()
    old: list[OldRun] = []
    kept: list[KeptRun] = []
    for folder in reversed(_folders_in(runs)):
        own, dry_run = cell_file_of(folder), folder.name.endswith(DRY_RUN)
        begun = _begun(folder)
        # A run that does not say what cell it is of counts as each cell's, as in `unfinished_run`.
        counting = {(own, dry_run), (None, dry_run)} if begun else set(newer)
        rank = sum(newer[key] for key in counting)
        newer[own, dry_run] += begun
        if cell is not None and own != cell.resolve():
            continue
        updated = _updated(folder)
        if rank < keep:
            newest = "the newest" if keep == 1 else f"one of the {keep} newest"
            kept.append(KeptRun(folder, f"it is {newest} of its cell"))
        elif why := obstacle(folder):
            kept.append(KeptRun(folder, why))
        elif latest is not None and updated > latest:
            kept.append(KeptRun(folder, f"it was last written on {updated:%Y-%m-%d}"))
        else:
            old.append(OldRun(folder, updated, _size(folder)))
    return Pruning(tuple(reversed(old)), tuple(reversed(kept)))


def prune(
    runs: Path, *, keep: int = 1, older_than: timedelta | None = None, cell: Path | None = None
) -> Pruning:
    """Remove the runs that `old_runs` returns, each with its whole folder, the oldest first.

    A run is locked while it is removed, so that nobody resumes it, and its folder is renamed first: a removal
    that is cut short leaves no half of a run, and the next one finishes it. A run that has come into use, or
    is held, in the meantime stays.

    Parameters
    ----------
    runs, keep, older_than, cell
        As for `old_runs`.

    Returns
    -------
    Pruning
        What was removed, and what was not.

    Raises
    ------
    ArgumentError
        As `old_runs`.
    JournalError
        If a folder cannot be removed. Those before it are gone, those after it are untouched.
    """
    _check(runs, keep, older_than)
    for folder in runs.glob(f"*{REMOVED}"):  # of a removal that was cut short
        _remove(folder)
    found = old_runs(runs, keep=keep, older_than=older_than, cell=cell)
    removed: list[OldRun] = []
    kept = list(found.kept)
    for run in found.old:
        if why := _removed(run.folder):
            kept.append(KeptRun(run.folder, why))
        else:
            removed.append(run)
    return Pruning(tuple(removed), tuple(sorted(kept, key=lambda run: run.folder)))


def prune_quietly(runs: Path, *, keep: int, cell: Path) -> None:
    """Remove the old runs of a cell, as `prune`; what cannot be removed is a warning, for a run goes on."""
    try:
        prune(runs, keep=keep, cell=cell)
    except JournalError as reason:
        warnings.warn(f"old runs are not removed: {reason}", stacklevel=2)


def _removed(folder: Path) -> str | None:
    """Remove a run; return why it was not, or None."""
    away = folder.with_name(f"{folder.name}{REMOVED}")
    try:
        with locked(f"the run {folder}", folder / LOCK):
            if why := obstacle(folder, locked_here=True):
                return why
            folder.rename(away)
    except InUseError as reason:
        return str(reason)
    except OSError as reason:
        raise _not_removed(folder, reason) from reason
    _remove(away)
    return None


def _remove(folder: Path) -> None:
    try:
        shutil.rmtree(folder)
    except OSError as reason:
        raise _not_removed(folder, reason) from reason


def _not_removed(folder: Path, reason: OSError) -> JournalError:
    return JournalError(f"{folder} cannot be removed: {reason}; check whose it is, and that it is writable")


def obstacle(folder: Path, *, locked_here: bool = False) -> str | None:
    """Return why a run must not be removed, however old it is; None if it may be.

    Parameters
    ----------
    folder
        The run's.
    locked_here
        Whether this process itself holds the run's lock.
    """
    if not locked_here and in_use(folder / LOCK):
        holder = holder_of(folder / LOCK)
        return "it is in use" if holder is None else f"it is in use by process {holder.pid}"
    try:
        if not has_entries(folder / JOURNAL):
            return None
        if status_of(folder).condition is Condition.HELD:
            return "it is held: see `beltsort status`"
        if is_moving(folder / JOURNAL):
            return _queued(folder / JOURNAL)
        pending = progress_in(folder / JOURNAL).pending
    except JournalError as reason:
        return f"its journal cannot be read ({reason})"
    if pending is not None and isinstance(pending.act, SortInto):
        return f"it ended during {pending.id}, of which nobody has said whether it was done"
    return None


def _queued(journal: Path) -> str | None:
    """Return why a run on a belt that never stops must not be removed."""
    if queued := list(moving_state_in(journal).diversions):
        return f"it ended before the belt had told what became of objects {queued}"
    return None


def _check(runs: Path, keep: int, older_than: timedelta | None) -> None:
    if keep < 1:
        raise ArgumentError(
            f"keep is {keep}, expected at least 1: the newest run says where the belt is; remove its folder "
            "by hand if the cell is no longer used"
        )
    if older_than is not None and older_than < timedelta():
        raise ArgumentError(f"older_than is {older_than}, expected at least 0; give an age")
    if _is_run(runs):
        raise ArgumentError(f"{runs} is a run, expected a folder of runs: name {runs.parent}")


def _folders_in(runs: Path) -> list[Path]:
    """Return the folders of runs, oldest first; also of those that ended before they had a journal."""
    return sorted(
        folder
        for folder in runs.glob("*")
        if folder.is_dir()
        and not folder.is_symlink()
        and not folder.name.endswith(REMOVED)
        and _is_run(folder)
    )


def _is_run(folder: Path) -> bool:
    return (folder / JOURNAL).is_file() or (folder / LOCK).is_file()


def _begun(folder: Path) -> bool:
    """Return whether a run has entries; of one whose journal cannot be read this is not known."""
    try:
        return has_entries(folder / JOURNAL)
    except JournalError:
        return False


def _updated(folder: Path) -> datetime:
    """Return when a run's journal was last written, or its folder if it has none."""
    times = [file.stat().st_mtime for file in (folder / JOURNAL, folder / f"{JOURNAL}-wal") if file.exists()]
    return datetime.fromtimestamp(max(times, default=folder.stat().st_mtime), UTC)


def _size(folder: Path) -> int:
    size = 0
    for file in folder.rglob("*"):
        with suppress(OSError):  # gone meanwhile
            size += 0 if file.is_dir() else file.lstat().st_size
    return size
