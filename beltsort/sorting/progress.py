"""The state of a run, as a function of its journal.

The loop changes its state only by writing an entry and then applying it. A run that was killed at any moment
is therefore restored by applying its entries again.
"""

from collections.abc import Iterable
from dataclasses import replace
from itertools import chain
from typing import Any, assert_never

from beltsort._core import Belief, SortingModel
from beltsort.cell.commands import AdvanceTo, MoveTo, Outcome, SortInto
from beltsort.errors import JournalError
from beltsort.sorting.command import Command
from beltsort.sorting.entries import (
    Answered,
    Chosen,
    CommandDone,
    CommandFailed,
    Decided,
    Drifted,
    Ended,
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
    StateChanged,
    Unheard,
)
from beltsort.sorting.first_entry import model_of
from beltsort.sorting.journal import Entry
from beltsort.sorting.moving.entries import MovingContent
from beltsort.sorting.report import Counts, Decision
from beltsort.sorting.rules import Seen
from beltsort.sorting.run_state import LATEST, Next, RunState


class Progress(RunState):
    """The state of a run, which its entries change.

    The attributes are those of `beltsort.sorting.run_state.RunState`.
    """

    @classmethod
    def at_start(cls, model: SortingModel, keep: int | None = LATEST) -> "Progress":
        """Return the state before the first entry."""
        seen = [Seen() for _ in range(model.positions)]
        return cls(model, Belief(model), visible=seen, counts=Counts.none(model), keep=keep)

    @classmethod
    def after(cls, entries: Iterable[Entry], keep: int | None = LATEST) -> "Progress":
        """Return the state after the entries of a run, from its start or a snapshot on: at least one.

        Raises
        ------
        JournalError
            If the first entry is another, or an entry contradicts those before it.
        """
        following = iter(entries)
        first = next(following)
        progress = cls.at_start(model_of([first]), keep)
        for entry in chain([first], following):
            progress.apply(entry)
        return progress

    def apply(self, entry: Entry) -> None:
        """Update the state with an entry.

        Raises
        ------
        JournalError
            If the entry contradicts those before it.
        """
        if isinstance(entry.content, MovingContent):
            raise JournalError(
                f"entry {entry.number} ({entry.kind}) is of a belt that never stops, expected one of a belt "
                "that stops: resume the run with the cell file that it began with"
            )
        match entry.content:
            case Started() as start:
                self._start(start)
            case Resumed(drift=drift):
                self._resume(drift)
            case Intended(command):
                self.pending, self.known_outcome, self.settled = command, None, None
                self.commands += int(command.attempt == 1)
            case CommandDone(command_id, stopped=stopped):
                self._done(self._pending(command_id), stopped)
            case CommandFailed(command_id, final=final):
                self._pending(command_id)
                self.known_outcome = Outcome.NOT_DONE if final else self.known_outcome
            case Answered(command_id, outcome):
                self._pending(command_id)
                self.known_outcome, self.settled = Outcome(outcome), None
            case Settled(answer):
                self.settled = answer
            case ObjectsPassed(index):
                self._pass(index)
            case Scanned() as scan:
                self._scan(scan)
            case ScanUnusable():
                self.scans += 1
            case ScanElsewhere():
                self.scans += 1
                self.arrived, self.missed_arrivals = False, self.missed_arrivals + 1
            case Drifted():
                self.drift.reported += 1
            case Decided() as decided:
                self._decide(decided)
            case Skipped(decided=was_planned):
                self.steps += int(was_planned)
                self.keep_latest(self.skipped, [self.index])
                self.counts = replace(self.counts, skipped=self.counts.skipped + 1)
                self.next = Next.ADVANCE
            case Requested(action="continue"):
                self.arrived, self.missed_arrivals = False, 0  # the arm may have been moved meanwhile
            case Snapshot() as snapshot:
                self.restore(snapshot)
            case StateChanged() | Planned() | Chosen() | Requested() | Unheard() | Ended():
                pass  # information for people only
            case content:
                assert_never(content)

    def _start(self, start: Started) -> None:
        self.run, self.objects, self.belt_ends = start.run, start.objects, start.belt_ends
        self.index = self.first = start.first
        self.belief = Belief(self.model, remaining=self.remaining)
        self.drift.begin(self.model, start.drift)

    def _resume(self, drift: dict[str, Any] | None) -> None:
        self.drift.begin(self.model, drift)
        self.arrived, self.missed_arrivals = False, 0  # the arm may have been moved or repaired
        self.stopped = 0.0  # the clock may have been restarted; the arm is moved before the next scan

    def _pending(self, command_id: str) -> Command:
        """Return the pending command, to which an entry must refer."""
        if self.pending is None or self.pending.id != command_id:
            raise JournalError(
                f"the journal contains the outcome of {command_id}, which was not pending; it is damaged"
            )
        return self.pending

    def _done(self, command: Command, stopped: float | None) -> None:
        self.pending = self.known_outcome = self.settled = None
        self.stopped = max(self.stopped, stopped or 0.0)
        match command.act:
            case MoveTo(viewpoint):
                self.viewpoint, self.arrived = viewpoint, True
                if not command.arriving:
                    self.steps += 1
                    self.next = Next.SCAN
            case SortInto():
                self.bin = None
            case AdvanceTo(index):
                self._shift(index)
                looks = self.model.observe_after_decision and self.index < self.end
                self.next = Next.SCAN if looks else Next.CHOOSE
            case act:
                assert_never(act)

    def _pass(self, index: int) -> None:
        """Continue at object `index`; those that passed the belt end unsorted are lost to the run."""
        if self.bin is not None and self.decisions:  # the object never reached its bin
            self.counts = self.counts.with_decision(self.decisions.pop(), self.model, -1)
        finished = self.next is Next.ADVANCE and self.bin is None  # sorted or skipped
        passed = range(self.index + finished, min(index, self.end))
        self.keep_latest(self.passed, passed)
        self.counts = replace(self.counts, passed=self.counts.passed + len(passed))
        self.pending = self.known_outcome = self.settled = self.bin = None
        while self.index < min(index, self.end):
            self._shift(self.index + 1)
        self.next, self.arrived = Next.CHOOSE, False  # the operator may have moved the arm

    def _shift(self, index: int) -> None:
        """Update the state after an advance of the belt by one object."""
        self.index, self.scans = index, 0
        self.belief.advance()
        self.visible = [*self.visible[1:], Seen()]

    def _scan(self, scan: Scanned) -> None:
        self.scans, self.missed_arrivals = self.scans + 1, 0
        self.drift.see(self.belief, scan.viewpoint, scan.labels)
        if scan.pose_fault is not None:
            self.pose_faults[scan.pose_fault] = self.pose_faults.get(scan.pose_fault, 0) + 1
        self.belief = Belief(self.model, scan.kinds or scan.belief, scan.last_labels, self.remaining)
        dropped = {drop["position"] for drop in scan.dropped}
        for position, (seen, label) in enumerate(zip(self.visible, scan.labels, strict=True)):
            seen.looks += 1
            seen.empty = [*seen.empty, scan.viewpoint] if scan.empty[position] else []
            if label is not None:
                seen.impossible = seen.impossible + 1 if position in dropped else 0
        self.next = Next.CHOOSE

    def _decide(self, decided: Decided) -> None:
        self.steps += 1
        decision = decision_of(self.index, decided)
        self.keep_latest(self.decisions, [decision])
        self.counts = self.counts.with_decision(decision, self.model)
        self.bin, self.next = decided.bin, Next.ADVANCE


def decision_of(index: int, decided: Decided) -> Decision:
    """Return the decision about object `index` that an entry holds."""
    return Decision(index, decided.label, decided.belief, decided.looks, decided.forced, decided.true_class)
