"""Journal entries as text, one line each."""

import ast
import re
from collections.abc import Iterable
from typing import Any

from beltsort import SortingModel
from beltsort.cell.bins import Bin
from beltsort.perception import Finding
from beltsort.planning.decisions import likeliest_in_words
from beltsort.sorting.entries import (
    Chosen,
    CommandFailed,
    Decided,
    Drifted,
    Intended,
    ObjectsPassed,
    Planned,
    Requested,
    Resumed,
    ScanElsewhere,
    Scanned,
    ScanUnusable,
    Settled,
    Skipped,
    Snapshot,
    Started,
    State,
    StateChanged,
)
from beltsort.sorting.holds import Way
from beltsort.sorting.journal import Entry
from beltsort.sorting.moving.entries import (
    Looked,
    MovingContent,
    MovingResumed,
    MovingSnapshot,
    MovingStarted,
)
from beltsort.sorting.moving.entry_text import MovingFormatter
from beltsort.sorting.rules import forced_in_words
from beltsort.util.text import counted, position_number

EXCEPTION = re.compile(r"""\w+\((['"].*['"])\)""", re.DOTALL)
"""`repr` of an exception with a message."""


def in_words(reason: str, ways: Iterable[Way] | None = None) -> str:
    """Return the reason of a change of state; of an exception its message, without `held` before it.

    If `ways` to continue are given, those at the end of the message are left out.

    Examples
    --------
    >>> in_words("HeldError('held: the camera is gone')")
    'the camera is gone'
    >>> in_words("HeldError('held at sort 2: a bin is full')")
    'at sort 2: a bin is full'
    >>> in_words("Interrupted('SIGINT')")
    'SIGINT'
    """
    exception = EXCEPTION.fullmatch(reason)
    if exception is None:
        return reason
    try:
        message = re.sub("^held(: | (?=at ))", "", str(ast.literal_eval(exception[1])))
        return message.removesuffix(f" {'; '.join(map(str, ways or ()))}")
    except (ValueError, SyntaxError):
        return reason


class EntryFormatter:
    """Formats the entries of one run, in order, as lines of text.

    Attributes
    ----------
    classes, labels, bins, viewpoints
        Names; empty before the first entry.
    belief
        Belief after the last entry: H rows of L probabilities, the belt end first.
    """

    def __init__(self) -> None:
        self.classes: list[str] = []
        self.labels: list[str] = []
        self.bins: list[str] = []
        self.viewpoints: list[str] = []
        self.belief: list[list[float]] = []
        self._arrival: list[float] = []
        self._first_row: int | None = None  # number of the object that the belief's first row is about
        self._pose_faults: set[str] = set()
        self._moving = MovingFormatter()

    def format(self, entry: Entry) -> str | None:
        """Return the line of an entry with the number of its object, or None if it is not shown."""
        text = self.text(entry)
        if text is None or entry.object is None or self._moving.belt is not None:
            return text  # on a belt that never stops, entries name their objects
        return f"object {entry.object:>2}  {text}"

    def text(self, entry: Entry) -> str | None:
        """Return the text of an entry, or None for an entry that is not shown."""
        self._follow(entry)
        match entry.content:
            case Started() | Snapshot() | Resumed() as first if not self.classes:
                text = self._start(first)
            case StateChanged(State.HELD | State.ABORTED as state, reason):
                text = f"{state.lower()}: {in_words(reason)}"
            case MovingStarted() | MovingSnapshot() | MovingResumed() as first if not self.classes:
                text = self._moving.start(first)
                self._names(self._moving.model)
            case content if isinstance(content, MovingContent):
                return self._moving.text(content)
            case Resumed():
                text = "resumed"
            case Requested("continue", by):
                text = f"continued: {by} asked to"
            case Requested("stop", by):
                text = f"stopped: {by} asked to"
            case Settled(answer, by):
                text = f"answered: {answer}, says {by}"
            case CommandFailed(command_id, outcome, error):
                text = f"{command_id} {outcome}: {in_words(error)}"
            case Scanned() as scan:
                text = self._scan(scan)
            case Drifted() as alarm:
                text = self._drift(alarm)
            case ScanUnusable(error):
                text = f"unusable scan: {error}"
            case ScanElsewhere() as scan:
                text = self._wrong_viewpoint(scan)
            case Decided() as decided:
                text = self._decision(decided)
            case Intended(command, str(name), int(number)):
                again = f", attempt {command.attempt}" if command.attempt > 1 else ""
                text = f"into {Bin(name, number)}{again}"
            case Skipped():
                text = "empty cup, skipped"
            case _:
                return None
        return text

    def continue_from(self, belief: list[list[float]], index: int) -> None:
        """Continue with the belief of a run that is resumed with object `index` at the belt end."""
        self.belief, self._first_row = belief, index

    def advance_to(self, index: int) -> None:
        """Shift the belief, as when object `index` arrives at the belt end; done once for each object."""
        if self._first_row is not None and index > self._first_row:
            gone = min(index - self._first_row, len(self.belief))
            self.belief = [*self.belief[gone:], *[self._arrival] * gone]
            self._first_row = index

    def _follow(self, entry: Entry) -> None:
        """Let the belief follow the belt, from a decision on, which takes the object off it."""
        match entry.content:
            case Scanned():
                self._first_row = entry.object
            case Decided() | Skipped() if entry.object is not None:
                self._first_row = entry.object
                self.advance_to(entry.object + 1)
            case ObjectsPassed(index):
                self.advance_to(index)

    def why(self, plan: Planned | Chosen) -> str:
        """Return the values of the plan's best and second-best action, or the reason given by a rule."""
        if isinstance(plan, Chosen):
            return plan.why or ""
        best, *others = sorted(plan.values, key=lambda action: -action["value"])
        if not others:
            return f"{self.name(best)} is the only legal action"
        return " ".join(
            [
                f"{self.name(best)} is worth {best['value']:.2f},",
                f"{self.name(others[0])} {others[0]['value']:.2f}",
            ]
        )

    def name(self, action: dict[str, Any]) -> str:
        """Return the text of an action in the journal's format, `{"move": 2}`."""
        if "move" in action:
            return f"look from {self.viewpoints[action['move']]}"
        if "wait" in action:
            return "wait"
        where = f" at position {position_number(action['position'])}" if "position" in action else ""
        return f"decide {self.bins[action['decide']]}{where}"

    def likely(self, row: list[float]) -> str:
        """Return the most likely class of one position, or classes equally likely, and its probability."""
        return f"{likeliest_in_words(row, self.classes)} {max(row):.2f}"

    def _start(self, first: Started | Snapshot | Resumed) -> str:
        model = SortingModel.from_json(first.model)
        self._names(model)
        self._arrival = model.arrival.tolist()
        self.belief = [self._arrival] * model.positions
        into = "" if self.bins == self.classes else f", into {', '.join(self.bins)}"
        number = "" if first.objects is None else f"{first.objects} "
        return f"sorting {number}objects: {', '.join(self.classes)}{into}"

    def _names(self, model: SortingModel) -> None:
        self.classes, self.viewpoints = model.classes, model.viewpoints
        self.labels, self.bins = model.labels, model.bins

    def seen(self, scan: Scanned | Looked) -> list[str]:
        """Return the label that a scan gave at each position, `?` for none, or why there is none.

        On a belt that never stops, return that of each object that it names.
        """
        if isinstance(scan, Looked):
            return [self._moving.seen(each) for each in scan.seen]
        return [
            finding if finding != Finding.OBJECT else "?" if label is None else self.labels[label]
            for label, finding in zip(scan.labels, scan.findings, strict=True)
        ]

    def _scan(self, scan: Scanned) -> str:
        seen = self.seen(scan)
        self.belief = scan.belief
        beliefs = " | ".join(self.likely(row) for row in self.belief)
        look = f"look from {self.viewpoints[scan.viewpoint]}: {' | '.join(seen)}  ->  {beliefs}"
        return f"{look}{self._new_fault(scan.pose_fault)}"

    def _new_fault(self, fault: str | None) -> str:
        """Return a warning about the pose of a scan; nothing if none is due, or it was given before."""
        if fault is None or fault in self._pose_faults:
            return ""
        self._pose_faults.add(fault)
        return f"  warning: the belt is not where the pose says; likely: {fault}"

    def _wrong_viewpoint(self, scan: ScanElsewhere) -> str:
        there = scan.stands_at
        where = "elsewhere" if there is None else f"at {self.viewpoints[there]}"
        return (
            f"wrong viewpoint: the camera stands {where}, {scan.angle:.1f} degrees and "
            f"{scan.distance:.0f} mm from {self.viewpoints[scan.viewpoint]}; the scan is dropped"
        )

    def _drift(self, alarm: Drifted) -> str:
        where = ""
        if alarm.viewpoint is not None and alarm.position is not None:
            where = f" at position {position_number(alarm.position)} from {self.viewpoints[alarm.viewpoint]}"
        return f"warning: labels{where} no longer fit the observation tables; estimate the tables again"

    def _decision(self, decided: Decided) -> str:
        what = "reject" if decided.label is None else f"decide {self.bins[decided.label]}"
        forced = f", forced: {forced_in_words(decided.forced)}" if decided.forced else ""
        return f"{what}  (belief {decided.belief:.3f}, {counted(decided.looks, 'look')}{forced})"
