"""The course of a run as far as it has been read: the state before each planner step, and what went wrong."""

from collections.abc import Sequence
from dataclasses import dataclass

from beltsort import Belief
from beltsort.planning.decisions import likeliest_classes
from beltsort.sorting.audit import Step, StepReader
from beltsort.sorting.entries import Scanned
from beltsort.sorting.first_entry import model_of
from beltsort.sorting.journal import Entry
from beltsort.sorting.progress import Progress
from beltsort.watch.base import History


@dataclass(frozen=True)
class ScanMark:
    """The last scan at some time.

    Attributes
    ----------
    entry
        Number of its journal entry.
    object
        Number of the object that was at the belt end.
    viewpoint
        Where the camera stood: an index.
    classes
        The most likely class at each position after it, an index; None where no class is likelier than all
        others.
    """

    entry: int
    object: int
    viewpoint: int
    classes: tuple[int | None, ...]


@dataclass(frozen=True, eq=False)
class Moment:
    """The state of a run when the action of a step was chosen, or after the last entry.

    Attributes
    ----------
    time
        UTC, ISO 8601.
    step
        The step; after the last entry the latest one, None if there is none.
    belief, viewpoint
        Belief and viewpoint.
    index
        Number of the object at the belt end.
    looks
        Scans in which the object at each position was visible.
    seen
        The last label at each position, or why there was none; empty where none has been looked at.
    scan
        The last scan; None before the first.
    sorted, skipped, passed
        Numbers of decisions, of empty cups, and of objects that passed unsorted.
    seconds
        Time spent executing.
    """

    time: str
    step: Step | None
    belief: Belief
    viewpoint: int
    index: int
    looks: tuple[int, ...]
    seen: tuple[str, ...]
    scan: ScanMark | None
    sorted: int
    skipped: int
    passed: int
    seconds: float


def most_likely(row: Sequence[float]) -> int | None:
    """Return the class that is likelier than every other; None if there is none."""
    found = likeliest_classes(row)
    return found[0] if len(found) == 1 else None


class RunHistory(History[Moment]):
    """Reads the entries of a run on a belt that stops, one after the other; see `History`.

    Attributes
    ----------
    progress
        The state after the last entry.
    """

    def __init__(self, first: Entry) -> None:
        super().__init__(first)
        self._reader = StepReader(model_of([first]))
        self._seen = ("",) * self.progress.model.positions
        self._scan: ScanMark | None = None
        self._step: Step | None = None
        self._pose_faults: set[str] = set()

    @property
    def progress(self) -> Progress:
        """The state after the last entry."""
        return self._reader.progress

    def now(self) -> Moment:
        """Return the state after the last entry, in which an object being sorted is not sorted yet."""
        sorting = self.progress.bin is not None
        return self._moment(self._step, len(self.progress.decisions) - sorting)

    def follow(self, entry: Entry) -> None:
        """Follow the run's progress, and keep the state before a planner step."""
        decided, index = len(self.progress.decisions), self.progress.index
        step = self._reader.read(entry)
        if step is not None:
            self._step = step
            self.keep(step.number, self._moment(step, decided))
        if self.progress.index > index:
            shifted = min(self.progress.index - index, len(self._seen))
            self._seen = (*self._seen[shifted:], *[""] * shifted)
        if isinstance(entry.content, Scanned):
            self._follow_scan(entry, entry.content)

    def _follow_scan(self, entry: Entry, scan: Scanned) -> None:
        """Keep what a scan has shown; a fault of its pose is an alarm the first time."""
        self._seen = tuple(self.names.seen(scan))
        classes = tuple(map(most_likely, scan.belief))
        self._scan = ScanMark(entry.number, self.progress.index, scan.viewpoint, classes)
        fault = scan.pose_fault
        if fault is not None and fault not in self._pose_faults:
            self._pose_faults.add(fault)
            self.alarm(entry, "pose", f"the belt is not where the pose says; likely: {fault}")

    def _moment(self, step: Step | None, decided: int) -> Moment:
        progress = self.progress
        return Moment(
            self.time,
            step,
            progress.belief.copy(),
            progress.viewpoint,
            progress.index,
            tuple(seen.looks for seen in progress.visible),
            self._seen,
            self._scan,
            decided,
            len(progress.skipped),
            len(progress.passed),
            self.seconds,
        )
