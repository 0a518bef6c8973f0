"""Labels of scans, written to disk as soon as they are known, so that interrupted work resumes."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeAlias, TypeVar

from beltsort.errors import RecordingError
from beltsort.util.keyed_log import KeyedLog
from beltsort.util.processes import Progress, in_processes

Labels: TypeAlias = dict[str, tuple[int | None, ...]]
"""Labels of each position, by the scan's key."""

Work = TypeVar("Work")


class LabelLog(KeyedLog):
    """Labels by scan; see `KeyedLog`.

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

    table, contents = "scans", "labels"
    maker, error = "`beltsort estimate`", RecordingError

    def labels(self) -> Labels:
        """Return all labels, in the order in which they were written."""
        return {key: tuple(labels) for key, labels in self.values().items()}


def label_missing(
    task: Callable[[Work], Mapping[str, Any]],
    work: Sequence[Work],
    keys: Callable[[Work], Sequence[str]],
    log: KeyedLog,
    workers: int | None,
    progress: Progress | None,
) -> None:
    """Label, or match, what the log does not hold yet, and append it piece by piece.

    Parameters
    ----------
    task
        Labels all scans of a piece of work, as the log keeps them.
    work
        The pieces.
    keys
        Returns the keys of the scans of a piece.
    log
        Where the results go.
    workers, progress
        As in `in_processes`.
    """
    known = log.values().keys()
    waiting = [piece for piece in work if not known >= set(keys(piece))]
    for results in in_processes(task, waiting, workers, progress):
        log.append(results)
