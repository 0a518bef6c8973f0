"""Labels of scans, written to disk as soon as they are known, so that interrupted work resumes."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple, TypeAlias, TypeVar

from beltsort.errors import RecordingError
from beltsort.perception.finding import Finding
from beltsort.perception.pipeline import Perceived
from beltsort.perception.pose_fault import PoseCause, PoseFault
from beltsort.util.keyed_log import KeyedLog
from beltsort.util.processes import Progress, in_processes

Labels: TypeAlias = dict[str, tuple[int | None, ...]]
"""Labels of each position, by the scan's key."""

Work = TypeVar("Work")


class PositionLabel(NamedTuple):
    """What is kept of one position of a scan.

    Attributes
    ----------
    label
        The label, or None.
    finding
        What was found; None if it was not kept.
    pose_fault
        What is likely wrong with the scan's pose, or None.
    """

    label: int | None
    finding: Finding | None = None
    pose_fault: PoseFault | None = None

    @classmethod
    def of(cls, perceived: Perceived) -> "PositionLabel":
        """Return what is kept of a perceived position."""
        return cls(perceived.label, perceived.finding, perceived.pose_fault)


PositionLabels: TypeAlias = dict[str, tuple[PositionLabel, ...]]
"""What is kept of each position, by the scan's key."""


class LabelLog(KeyedLog):
    """Labels by scan, and what was found; see `KeyedLog`. A log may also hold labels alone.

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

    def append(self, values: Mapping[str, Sequence[int | PositionLabel | None]]) -> None:
        """Write labels durably. Keys that exist already keep theirs."""
        super().append({key: [_plain(each) for each in positions] for key, positions in values.items()})

    def labels(self) -> Labels:
        """Return all labels, in the order in which they were written."""
        return {key: tuple(each.label for each in kept) for key, kept in self.positions().items()}

    def positions(self) -> PositionLabels:
        """Return all that is kept, in the order in which it was written."""
        return {key: tuple(map(_position, positions)) for key, positions in self.values().items()}


def _plain(position: int | PositionLabel | None) -> int | dict[str, Any] | None:
    if not isinstance(position, PositionLabel):
        return position
    return {"label": position.label, "finding": position.finding, **plain_fault(position.pose_fault)}


def _position(plain: int | dict[str, Any] | None) -> PositionLabel:
    if not isinstance(plain, dict):
        return PositionLabel(plain)
    finding = plain["finding"]
    return PositionLabel(plain["label"], None if finding is None else Finding(finding), fault_in(plain))


def plain_fault(fault: PoseFault | None) -> dict[str, Any]:
    """Return a fault as a part of plain data, of which it is no part if there is none."""
    return {} if fault is None else {"pose_fault": fault.cause.name, "height": fault.height}


def fault_in(plain: Mapping[str, Any]) -> PoseFault | None:
    """Return the fault in plain data, or None."""
    return PoseFault(PoseCause[plain["pose_fault"]], plain["height"]) if "pose_fault" in plain else None


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
