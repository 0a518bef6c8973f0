"""What the entries of every run tell, whatever its belt does: its state, its alarms, the time taken."""

from abc import ABC, abstractmethod
from collections import Counter, deque
from collections.abc import Iterable
from dataclasses import dataclass
from datetime import datetime
from typing import Generic, TypeVar

from beltsort.errors import JournalError
from beltsort.sorting.entries import (
    Answered,
    CommandFailed,
    Decided,
    Drifted,
    Ended,
    Requested,
    Resumed,
    ScanElsewhere,
    ScanUnusable,
    Settled,
    Started,
    State,
    StateChanged,
    Unheard,
)
from beltsort.sorting.entry_text import EntryFormatter, in_words
from beltsort.sorting.journal import Entry
from beltsort.sorting.moving.entries import MovingResumed, MovingStarted
from beltsort.sorting.settling import Question, question_after

MOMENTS, ALARMS = 20_000, 200
"""Numbers of planner steps and of alarms that are kept, the latest."""

MomentT = TypeVar("MomentT")


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


class History(ABC, Generic[MomentT]):
    """Reads the entries of a run, one after the other.

    Parameters
    ----------
    first
        The first entry that is still kept, to be read like all others.

    Attributes
    ----------
    names
        Formats entries, with the names of the run's model.
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
    last_entry
        Number of the last entry.
    time, seconds
        Time of the last entry (UTC, ISO 8601), and the time spent executing until then, seconds.
    """

    def __init__(self, first: Entry) -> None:
        self.names = EntryFormatter()
        self.moments: dict[int, MomentT] = {}
        self.alarms: deque[Alarm] = deque(maxlen=ALARMS)
        self.alarm_counts: Counter[str] = Counter()
        self.state, self.reason = State.EXECUTE, ""
        self.question: Question | None = None
        self.ended: str | None = None
        self.last_entry = 0
        self.time, self.seconds = first.time, 0.0

    def read(self, entries: Iterable[Entry]) -> None:
        """Read further entries."""
        for entry in entries:
            self._spend(entry)
            self.note(entry, self.names.format(entry) or "")
            self.follow(entry)
            self.question = question_after(self.question, entry)
            self.last_entry = entry.number

    @abstractmethod
    def follow(self, entry: Entry) -> None:
        """Apply an entry to the state of the run, and keep the state before a planner step."""

    @abstractmethod
    def now(self) -> MomentT:
        """Return the state after the last entry."""

    def moment(self, step: int | None) -> MomentT:
        """Return the state before a planner step, or after the last entry.

        Raises
        ------
        JournalError
            If the step is not among those kept.
        """
        moments = self.moments
        if step is None:
            return self.now()
        if step not in moments:
            kept = f"steps {min(moments)} to {max(moments)}" if moments else "no steps"
            raise JournalError(f"there is no step {step}; there are {kept}")
        return moments[step]

    def keep(self, step: int, moment: MomentT) -> None:
        """Keep the state before a planner step, in place of an earlier one if it was planned again."""
        self.moments.pop(step, None)
        self.moments[step] = moment
        if len(self.moments) > MOMENTS:
            del self.moments[next(iter(self.moments))]

    def alarm(self, entry: Entry, kind: str, text: str) -> None:
        """Keep an alarm, and count it."""
        self.alarms.append(Alarm(entry.number, entry.time, kind, text))
        self.alarm_counts[kind] += 1

    def _spend(self, entry: Entry) -> None:
        """Count the time since the last entry, unless the run was held or no process was there."""
        begins = Started | Resumed | MovingStarted | MovingResumed
        pause = isinstance(entry.content, begins) or self.ended is not None
        if self.state is State.EXECUTE and not pause:
            passed = datetime.fromisoformat(entry.time) - datetime.fromisoformat(self.time)
            self.seconds += max(0.0, passed.total_seconds())
        self.time = entry.time

    def note(self, entry: Entry, text: str) -> None:
        """Keep what an entry says about the state of the run, and what is an alarm, before it is applied.

        Parameters
        ----------
        entry
            The entry.
        text
            It as text; empty if it has none.
        """
        match entry.content:
            case StateChanged(state, reason, ways=ways):
                self.state, self.reason = state, in_words(reason, ways)
                if state is State.HELD:
                    self.alarm(entry, "held", text)
                elif state is State.ABORTED:
                    pressed = reason.startswith("EmergencyStopError")
                    self.alarm(entry, "emergency stop" if pressed else "aborted", text)
            case Started() | Resumed() | MovingStarted() | MovingResumed():
                self.ended = None
            case Ended(reason):
                self.ended = reason
            case ScanUnusable() | ScanElsewhere():
                self.alarm(entry, "scan failure", text)
            case Drifted():
                self.alarm(entry, "drift", text)
            case Decided(forced=str()):
                self.alarm(entry, "forced decision", text)
            case CommandFailed():
                self.alarm(entry, "command", text)
            case Answered(command_id, outcome):
                self.alarm(entry, "operator", f"the operator says: {command_id} was {outcome}")
            case Requested("continue" | "stop") | Settled():
                self.alarm(entry, "operator", text)
            case Unheard(error):
                self.alarm(entry, "display", f"a listener of the run failed: {error}")
