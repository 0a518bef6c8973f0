"""The messages on the topics of a run, as plain values, from the entries of its journal."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import NamedTuple, TypeAlias

from beltsort.cell.bins import REJECT
from beltsort.cell.commands import Act, AdvanceTo
from beltsort.sorting.entries import (
    CommandDone,
    Decided,
    Drifted,
    Intended,
    ObjectsPassed,
    Resumed,
    Scanned,
    Skipped,
    Started,
    State,
    StateChanged,
)
from beltsort.sorting.entry_text import EntryFormatter, in_words
from beltsort.sorting.journal import Entry
from beltsort.sorting.progress import Progress
from beltsort.sorting.settling import Question, question_after

Plain: TypeAlias = "str | int | float | Sequence[Plain] | Mapping[str, Plain]"
"""A field of a message: messages are dictionaries."""
Message: TypeAlias = Mapping[str, Plain]


class Topic(NamedTuple):
    """A topic: its name below that of the node, the type of its messages, and how many are kept."""

    name: str
    kind: str
    kept: int = 1


STATE = Topic("~/state", "diagnostic_msgs/DiagnosticArray")
BELIEF = Topic("~/belief", "std_msgs/Float64MultiArray")
DECISION = Topic("~/decision", "diagnostic_msgs/DiagnosticArray", kept=100)

OK, WARN, ERROR = 0, 1, 2
"""Levels of diagnostic_msgs/DiagnosticStatus."""
LEVELS = {State.HELD: WARN, State.ABORTED: ERROR}
"""Level of each state; that of others is OK."""


class Published(NamedTuple):
    """A message, and the name of its topic."""

    topic: str
    message: Message


@dataclass
class RunCounts:
    """Numbers of objects that have left the belt, and of warnings."""

    sorted: int = 0
    empty: int = 0
    passed: int = 0
    forced: int = 0
    drift: int = 0


class RunMessages:
    """The messages of one run.

    Attributes
    ----------
    held
        Whether the run is held.
    question
        The question at which it is held, to which a request to continue is no answer; None if there is none.
    moved
        Number of positions by which the belt has moved with the last entry.
    """

    def __init__(self) -> None:
        self.held = False
        self.question: Question | None = None
        self.moved = 0
        self._formatter = EntryFormatter()
        self._counts = RunCounts()
        self._run, self._state, self._reason = "", State.EXECUTE, ""
        self._objects: int | None = None
        self._viewpoint, self._last = "", ""
        self._advancing: int | None = None
        self._broken_off: Progress | None = None
        self._values: dict[str, str] = {}

    def resume(self, progress: Progress) -> None:
        """Continue with a run that is resumed, whose entries do not say where it was."""
        self._run, self._broken_off = progress.run, progress
        counts, known = self._counts, progress.counts
        counts.sorted, counts.empty, counts.forced = known.sorted, known.skipped, known.forced
        counts.passed, counts.drift = known.passed, len(progress.drift.alarms)

    def read(self, entry: Entry) -> list[Published]:
        """Read the next entry, and return the messages that it gives rise to."""
        self._last = self._formatter.text(entry) or self._last
        published: list[Published] = []
        self.moved = self._moved(entry)
        match entry.content:
            case Started(run=run):
                self._run = run
                published.append(self._belief_message())
            case Resumed():
                if (before := self._broken_off) is not None:
                    self._formatter.continue_from(before.belief.probabilities.tolist(), before.index)
                published.append(self._belief_message())
            case Scanned(viewpoint=viewpoint):
                self._viewpoint = self._formatter.viewpoints[viewpoint]
                published.append(self._belief_message())
            case CommandDone() | ObjectsPassed() if self.moved > 0:
                published.append(self._belief_message())
            case Decided() as decided:
                published.append(Published(DECISION.name, self._decision(entry, decided)))
        self._count(entry)
        return [*self._state_message(entry), *published]

    def _moved(self, entry: Entry) -> int:
        """Return by how many positions the belt has moved with an entry, and let the belief follow."""
        arrived: int | None = None
        match entry.content:
            case Resumed() if (before := self._broken_off) is not None and before.pending is not None:
                self._advancing = _target(before.pending.act)
            case Intended(command):
                self._advancing = _target(command.act)
            case CommandDone():
                arrived, self._advancing = self._advancing, None
            case ObjectsPassed(arrived):
                self._advancing = None
        if arrived is None or entry.object is None:
            return 0
        self._formatter.advance_to(arrived)
        return max(0, arrived - entry.object)

    def _count(self, entry: Entry) -> None:
        """Update state and counts."""
        self.question = question_after(self.question, entry)
        match entry.content:
            case Started(objects=objects) | Resumed(objects=objects):
                self._objects = objects
            case StateChanged(state, reason):
                self._state, self._reason = state, in_words(reason)
                self.held = state is State.HELD
            case Decided(forced=forced):
                self._counts.sorted += 1
                self._counts.forced += int(forced is not None)
            case Skipped():
                self._counts.empty += 1
            case ObjectsPassed(index) if entry.object is not None:
                self._counts.passed += max(0, index - entry.object)
            case Drifted():
                self._counts.drift += 1

    def _state_message(self, entry: Entry) -> list[Published]:
        """Return the message about the state of the run, unless it is as before."""
        counts = self._counts
        values = {
            "state": self._state.value,
            "reason": self._reason,
            "object": "" if entry.object is None else str(entry.object),
            "objects": "unlimited" if self._objects is None else str(self._objects),
            "viewpoint": self._viewpoint,
            "sorted": str(counts.sorted),
            "empty": str(counts.empty),
            "passed": str(counts.passed),
            "forced": str(counts.forced),
            "drift_alarms": str(counts.drift),
            "last": self._last,
        }
        if values == self._values:
            return []
        self._values = values
        text = f"{self._state.value}: {self._last if self._state is State.EXECUTE else self._reason}"
        level = LEVELS.get(self._state, OK)
        return [Published(STATE.name, self._diagnostic(entry, level, f"run {self._run}", text, values))]

    def _belief_message(self) -> Published:
        """Return the belief: a row for each position, the belt end first, a column for each class."""
        rows = self._formatter.belief
        width = len(self._formatter.classes)
        dimensions: list[Message] = [
            {"label": "position", "size": len(rows), "stride": len(rows) * width},
            {"label": "class", "size": width, "stride": width},
        ]
        data = [float(probability) for row in rows for probability in row]
        return Published(BELIEF.name, {"layout": {"dim": dimensions, "data_offset": 0}, "data": data})

    def _decision(self, entry: Entry, decided: Decided) -> Message:
        """Return the decision about an object, a warning if a rule forced it."""
        bin_name = REJECT if decided.label is None else self._formatter.bins[decided.label]
        values = {
            "object": str(entry.object),
            "bin": bin_name,
            "bin_number": str(decided.bin),
            "belief": f"{decided.belief:.6f}",
            "looks": str(decided.looks),
            "forced": decided.forced or "",
        }
        level = OK if decided.forced is None else WARN
        return self._diagnostic(entry, level, f"object {entry.object}", bin_name, values)

    def _diagnostic(
        self, entry: Entry, level: int, name: str, text: str, values: Mapping[str, str]
    ) -> Message:
        """Return a diagnostic_msgs/DiagnosticArray of one status, with the time of the entry."""
        pairs = [{"key": key, "value": value} for key, value in values.items()]
        status: Message = {
            "level": level,
            "name": f"beltsort: {name}",
            "message": text,
            "hardware_id": self._run,
            "values": pairs,
        }
        return {"header": {"stamp": stamp_of(entry.time), "frame_id": ""}, "status": [status]}


def _target(act: Act) -> int | None:
    """Return the object that a command brings to the belt end; None if it is not about the belt."""
    return act.object if isinstance(act, AdvanceTo) else None


def stamp_of(time: str) -> Message:
    """Return a time, ISO 8601, as builtin_interfaces/Time.

    Examples
    --------
    >>> stamp_of("1970-01-01T00:00:02.500000+00:00")
    {'sec': 2, 'nanosec': 500000000}
    """
    at = datetime.fromisoformat(time)
    return {"sec": int(at.timestamp()), "nanosec": 1000 * at.microsecond}
