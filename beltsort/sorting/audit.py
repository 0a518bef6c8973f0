"""Inspection of a run: its steps, and why each was taken."""

import csv
import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeGuard

from beltsort import Belief, Decide, Despot, Move, Plan, SortingModel
from beltsort.errors import JournalError
from beltsort.planning.decisions import best_bin
from beltsort.sorting.entries import (
    AnyContent,
    Chosen,
    Decided,
    Drifted,
    Planned,
    Resumed,
    ScanElsewhere,
    Scanned,
    ScanUnusable,
    Skipped,
    Started,
)
from beltsort.sorting.first_entry import model_of
from beltsort.sorting.journal import Entry, read_journal
from beltsort.sorting.progress import Progress
from beltsort.sorting.rules import forced_in_words
from beltsort.sorting.runs import journal_of

COLUMNS = ("number", "time", "kind", "object", "data")


@dataclass(frozen=True, eq=False)
class Step:
    """A planner step, with the state in which its action was chosen.

    Attributes
    ----------
    number
        Counts from 1.
    entry
        The entry of the plan, or of a decision that a rule forced.
    choice
        The content of that entry.
    belief, viewpoint
        Belief and viewpoint at that time.
    planner
        Settings of the planner; None for another policy.
    alarms
        Drift alarms that had been raised by then.
    """

    number: int
    entry: Entry
    choice: Planned | Chosen | Decided
    belief: Belief
    viewpoint: int
    planner: dict[str, Any] | None
    alarms: int = 0

    @property
    def model(self) -> SortingModel:
        """The model of the belief."""
        return self.belief.model

    @property
    def action(self) -> Move | Decide:
        """The action chosen; if a rule sent the object to the reject bin, the best decision."""
        if isinstance(self.choice, Decided):
            label = self.choice.label
            return Decide(best_bin(self.belief) if label is None else label)
        return action_of(self.choice.action)

    @property
    def reason(self) -> str | None:
        """Why a rule chose, in words; None if the policy did."""
        match self.choice:
            case Decided(forced=str(rule)):
                return forced_in_words(rule)
            case Chosen(why=why):
                return why
            case Planned() | Decided():
                return None

    def plan_again(self) -> Plan | None:
        """Plan again from the same belief and return the plan; None if `Despot` did not choose the action.

        The plan is the same if the budget was in trials. After a time budget the same number of trials is
        made, and the search may take another path.
        """
        if not isinstance(self.choice, Planned) or self.planner is None:
            return None
        trials = max(1, self.choice.trials)  # 0 if the root alone was decisive
        settings = {**self.planner, "seconds": None, "trials": trials}
        return Despot(self.model, **settings).plan(self.belief, self.viewpoint)


def entries_of(run: Path) -> list[Entry]:
    """Return the entries of a run.

    Parameters
    ----------
    run
        As in `beltsort.sorting.runs.journal_of`.

    Raises
    ------
    JournalError
        If there is no journal, or it is damaged.
    """
    return read_journal(journal_of(run))


def steps_of(entries: Sequence[Entry]) -> Iterator[Step]:
    """Yield the planner steps of a run, in order.

    Parameters
    ----------
    entries
        The entries, from the start of the run or a snapshot; steps count from the start in both cases.
    """
    reader = StepReader(model_of(entries))
    for entry in entries:
        step = reader.read(entry)
        if step is not None:
            yield step


class StepReader:
    """Finds the planner steps of a run, reading one entry after the other.

    Parameters
    ----------
    model
        The run's model.
    keep
        Number of the latest decisions, and the like, that its progress has; None: all of them.

    Attributes
    ----------
    progress
        The state after the last entry read.
    """

    def __init__(self, model: SortingModel, keep: int | None = None) -> None:
        self.progress = Progress.at_start(model, keep)
        self._planner: dict[str, Any] | None = None

    def read(self, entry: Entry) -> Step | None:
        """Apply the next entry; return the step whose action it chooses, or None."""
        choice, progress, step = entry.content, self.progress, None
        if isinstance(choice, Started | Resumed):
            self._planner = choice.planner
        if isinstance(choice, Planned | Chosen) or by_rule(choice):
            known = progress.belief.copy(), progress.viewpoint
            alarms = len(progress.drift.alarms)
            step = Step(progress.steps + 1, entry, choice, *known, self._planner, alarms)
        progress.apply(entry)
        return step

    def step_of(self, entry: Entry) -> int | None:
        """Apply the next entry; return the number of its step if it is a look or a decision, or None."""
        self.read(entry)
        match entry.content:
            case Scanned() | ScanUnusable() | ScanElsewhere() | Decided() | Skipped(decided=True):
                return self.progress.steps or None
        return None


def action_of(named: Mapping[str, Any]) -> Move | Decide:
    """Return an action that the journal keeps as `{"move": viewpoint}` or `{"decide": bin}`."""
    return Move(named["move"]) if "move" in named else Decide(named["decide"])


def by_rule(choice: AnyContent) -> TypeGuard[Decided]:
    """Tell whether an entry is a decision that a rule forced."""
    return isinstance(choice, Decided) and choice.forced is not None


def step_of(entries: Sequence[Entry], number: int) -> Step:
    """Return one planner step; if it was planned twice, because the run was killed in between, the second.

    Raises
    ------
    JournalError
        If the journal has no such step; the error names those that it has.
    """
    found, first, last = None, None, None
    for step in steps_of(entries):
        first, last = step.number if first is None else first, step.number
        if step.number == number:
            found = step
    if found is None:
        known = "no steps" if first is None else f"steps {first} to {last}"
        raise JournalError(f"there is no step {number}; the journal has {known}")
    return found


def with_steps(entries: Sequence[Entry]) -> Iterator[tuple[Entry, int | None]]:
    """Yield each entry; a look or a decision with the number of its planner step, others with None."""
    if not entries:
        return
    reader = StepReader(model_of(entries))
    for entry in entries:
        yield entry, reader.step_of(entry)


def incidents_of(entries: Sequence[Entry], step: Step) -> Iterator[Entry]:
    """Yield the entries of a step about unusable or misplaced scans and drift alarms."""
    for entry in entries:
        if entry.number > step.entry.number:
            if isinstance(entry.content, Planned | Chosen):
                return
            if isinstance(entry.content, ScanUnusable | ScanElsewhere | Drifted):
                yield entry


def write_csv(entries: Iterable[Entry], path: Path) -> int:
    """Write a row for each entry: number, time (UTC), kind, object, and data as JSON; return how many.

    Raises
    ------
    JournalError
        If the file cannot be written.
    """
    number = 0
    try:
        with path.open("w", newline="") as file:
            rows = csv.writer(file)
            rows.writerow(COLUMNS)
            for number, e in enumerate(entries, start=1):  # noqa: B007 - its last value is returned
                rows.writerow((e.number, e.time, e.kind, e.object, json.dumps(e.data)))
    except OSError as reason:
        raise JournalError(f"cannot write {path}: {reason}; choose a writable path") from reason
    return number
