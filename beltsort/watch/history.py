"""The course of a run as far as it has been read: the state before each planner step, and what went wrong."""

from collections import Counter, deque
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import datetime

from beltsort import Belief
from beltsort.planning.decisions import likeliest_classes
from beltsort.sorting.audit import Step, StepReader
from beltsort.sorting.entries import (
    Answered,
    CommandFailed,
    Decided,
    Drifted,
    Ended,
    Requested,
    Resumed,
    ScanElsewhere,
    Scanned,
    ScanUnusable,
    Settled,
    Started,
    State,
    StateChanged,
    Unheard,
)
from beltsort.sorting.entry_text import EntryFormatter, in_words
from beltsort.sorting.first_entry import model_of
from beltsort.sorting.journal import Entry
from beltsort.sorting.progress import Progress
from beltsort.sorting.settling import Question, question_after

MOMENTS, ALARMS = 20_000, 200
"""Numbers of planner steps and of alarms that are kept, the latest."""


@dataclass(frozen=True)
class Alarm:
    """An event that a person should know of.

    Attributes
    ----------
    entry
        Number of its journal entry.
    time
        UTC, ISO 8601.
    kind
        What kind of event it is, in a word or two.
    text
        What happened.
    """

    entry: int
    time: str
    kind: str
    text: str


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


class RunHistory:
    """Reads the entries of a run, one after the other.

    Parameters
    ----------
    first
        The first entry that is still kept, to be read like all others.

    Attributes
    ----------
    progress
        The state after the last entry.
    moments
        The state before each planner step, by the step's number; the latest `MOMENTS`.
    alarms
        The latest `ALARMS`.
    alarm_counts
        Number of all alarms, by kind.
    state, reason
        State of the run, and why it is in this state.
    question
        The question at which the run is held; None if there is none.
    ended
        Why the process that sorted ended; None while it runs, and after it was killed.
    """

    def __init__(self, first: Entry) -> None:
        self._reader = StepReader(model_of([first]))
        self.names = EntryFormatter()
        self.moments: dict[int, Moment] = {}
        self.alarms: deque[Alarm] = deque(maxlen=ALARMS)
        self.alarm_counts: Counter[str] = Counter()
        self.state, self.reason = State.EXECUTE, ""
        self.question: Question | None = None
        self.ended: str | None = None
        self.last_entry = 0
        self._time, self._seconds = first.time, 0.0
        self._seen = ("",) * self.progress.model.positions
        self._scan: ScanMark | None = None
        self._step: Step | None = None
        self._pose_faults: set[str] = set()

    @property
    def progress(self) -> Progress:
        """The state after the last entry."""
        return self._reader.progress

    def read(self, entries: Iterable[Entry]) -> None:
        """Read further entries."""
        for entry in entries:
            self._read(entry)

    def now(self) -> Moment:
        """Return the state after the last entry, in which an object being sorted is not sorted yet."""
        sorting = self.progress.bin is not None
        return self._moment(self._step, len(self.progress.decisions) - sorting)

    def _read(self, entry: Entry) -> None:
        self._spend(entry)
        text = self.names.format(entry) or ""
        decided, index = len(self.progress.decisions), self.progress.index
        step = self._reader.read(entry)
        if step is not None:
            self._step = step
            self.moments.pop(step.number, None)  # planned again after a kill
            self.moments[step.number] = self._moment(step, decided)
            if len(self.moments) > MOMENTS:
                del self.moments[next(iter(self.moments))]
        if self.progress.index > index:
            shifted = min(self.progress.index - index, len(self._seen))
            self._seen = (*self._seen[shifted:], *[""] * shifted)
        self.question = question_after(self.question, entry)
        self._note(entry, text)
        self.last_entry = entry.number

    def _spend(self, entry: Entry) -> None:
        """Count the time since the last entry, unless the run was held or no process was there."""
        pause = isinstance(entry.content, Started | Resumed) or self.ended is not None
        if self.state is State.EXECUTE and not pause:
            passed = datetime.fromisoformat(entry.time) - datetime.fromisoformat(self._time)
            self._seconds += max(0.0, passed.total_seconds())
        self._time = entry.time

    def _note(self, entry: Entry, text: str) -> None:
        """Keep what an entry says about scans, about the state of the run, and what is an alarm."""
        match entry.content:
            case Scanned() as scan:
                self._seen = tuple(self.names.seen(scan))
                classes = tuple(map(most_likely, scan.belief))
                self._scan = ScanMark(entry.number, self.progress.index, scan.viewpoint, classes)
                fault = scan.pose_fault
                if fault is not None and fault not in self._pose_faults:
                    self._pose_faults.add(fault)
                    self._alarm(entry, "pose", f"the belt is not where the pose says; likely: {fault}")
            case StateChanged(state, reason, ways=ways):
                self.state, self.reason = state, in_words(reason, ways)
                if state is State.HELD:
                    self._alarm(entry, "held", text)
                elif state is State.ABORTED:
                    pressed = reason.startswith("EmergencyStopError")
                    self._alarm(entry, "emergency stop" if pressed else "aborted", text)
            case Started() | Resumed():
                self.ended = None
            case Ended(reason):
                self.ended = reason
            case ScanUnusable() | ScanElsewhere():
                self._alarm(entry, "scan failure", text)
            case Drifted():
                self._alarm(entry, "drift", text)
            case Decided(forced=str()):
                self._alarm(entry, "forced decision", text)
            case CommandFailed():
                self._alarm(entry, "command", text)
            case Answered(command_id, outcome):
                self._alarm(entry, "operator", f"the operator says: {command_id} was {outcome}")
            case Requested("continue" | "stop") | Settled():
                self._alarm(entry, "operator", text)
            case Unheard(error):
                self._alarm(entry, "display", f"a listener of the run failed: {error}")

    def _alarm(self, entry: Entry, kind: str, text: str) -> None:
        self.alarms.append(Alarm(entry.number, entry.time, kind, text))
        self.alarm_counts[kind] += 1

    def _moment(self, step: Step | None, decided: int) -> Moment:
        progress = self.progress
        return Moment(
            self._time,
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
            self._seconds,
        )
