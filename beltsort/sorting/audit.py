"""Looking back at a run: its steps, and why each was taken."""

import csv
import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeGuard

from beltsort import Belief, Decide, Despot, Move, Plan, SortingModel
from beltsort.errors import JournalError
from beltsort.sorting.entries import (
    AnyContent,
    Chosen,
    Decided,
    Drifted,
    Planned,
    Resumed,
    ScanElsewhere,
    ScanUnusable,
    Started,
)
from beltsort.sorting.journal import Entry, read_journal
from beltsort.sorting.progress import Progress, model_of

JOURNAL = "journal.sqlite"
COLUMNS = ("number", "time", "kind", "object", "data")


@dataclass(frozen=True, eq=False)
class Step:
    """A planner step, as it was decided on.

    Attributes
    ----------
    number
        Counts from 1.
    entry
        Of the plan, or of a decision that a rule forced.
    choice
        What that entry tells.
    belief, viewpoint
        What was known then, and where the camera stood.
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
        """The model planned with."""
        return self.belief.model

    @property
    def action(self) -> Move | Decide:
        """What was chosen."""
        if isinstance(self.choice, Decided):
            return Decide(self.belief.most_likely(0)[0])
        action = self.choice.action
        return Move(action["move"]) if "move" in action else Decide(action["decide"])

    @property
    def reason(self) -> str | None:
        """Why a rule chose, in words; None if the policy did."""
        match self.choice:
            case Decided(forced=forced):
                return f"forced by {forced}"
            case Chosen(why=why):
                return why
            case Planned():
                return None

    def plan_again(self) -> Plan | None:
        """Return the plan, made once more; None if no planner made it.

        The same plan if the budget was one of trials. With a budget of time the trials that it had are done
        again, in which the search may have taken another path.
        """
        if not isinstance(self.choice, Planned) or self.planner is None:
            return None
        trials = max(1, self.choice.trials)  # none where the root alone settled it
        settings = {**self.planner, "seconds": None, "trials": trials}
        return Despot(self.model, **settings).plan(self.belief, self.viewpoint)


def entries_of(run: Path) -> list[Entry]:
    """Return the entries of a run.

    Parameters
    ----------
    run
        Its folder, or its journal.

    Raises
    ------
    JournalError
        If there is no journal, or it is damaged.
    """
    return read_journal(run / JOURNAL if run.is_dir() else run)


def steps_of(entries: Sequence[Entry]) -> Iterator[Step]:
    """Yield the planner steps of a run, in order.

    Parameters
    ----------
    entries
        From the start, or from a snapshot; then steps are counted from the run's start all the same.
    """
    progress = Progress.at_start(model_of(entries))
    planner: dict[str, Any] | None = None
    for entry in entries:
        choice = entry.content
        if isinstance(choice, Started | Resumed):
            planner = choice.planner
        if isinstance(choice, Planned | Chosen) or by_rule(choice):
            known = progress.belief.copy(), progress.viewpoint
            yield Step(progress.steps + 1, entry, choice, *known, planner, len(progress.drift.alarms))
        progress.apply(entry)


def by_rule(choice: AnyContent) -> TypeGuard[Decided]:
    """Tell whether an entry is a decision that a rule forced."""
    return isinstance(choice, Decided) and choice.forced is not None


def step_of(entries: Sequence[Entry], number: int) -> Step:
    """Return one planner step; the last plan of it, if a run that was killed made it twice.

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
        known = "of no step" if first is None else f"of steps {first} to {last}"
        raise JournalError(f"there is no step {number}; the journal tells {known}")
    return found


def befell(entries: Sequence[Entry], step: Step) -> Iterator[Entry]:
    """Yield what went otherwise than planned while a step was carried out."""
    for entry in entries:
        if entry.number > step.entry.number:
            if isinstance(entry.content, Planned | Chosen):
                return
            if isinstance(entry.content, ScanUnusable | ScanElsewhere | Drifted):
                yield entry


def write_csv(entries: Sequence[Entry], path: Path) -> None:
    """Write a row for each entry: number, time (UTC), kind, object, and data as JSON.

    Raises
    ------
    JournalError
        If the file cannot be written.
    """
    try:
        with path.open("w", newline="") as file:
            rows = csv.writer(file)
            rows.writerow(COLUMNS)
            rows.writerows((e.number, e.time, e.kind, e.object, json.dumps(e.data)) for e in entries)
    except OSError as reason:
        raise JournalError(f"cannot write {path}: {reason}; choose a writable path") from reason
