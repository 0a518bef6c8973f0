"""The state of a run as seen from another process."""

from dataclasses import asdict, dataclass
from enum import StrEnum
from pathlib import Path

from beltsort.sorting.entries import (
    Ended,
    Resumed,
    Started,
    State,
    StateChanged,
)
from beltsort.sorting.entry_text import in_words
from beltsort.sorting.journal import last_row
from beltsort.sorting.journal_files import JOURNAL
from beltsort.sorting.locks import holder_of, in_use
from beltsort.sorting.moving.entries import Fate, MovingResumed, MovingStarted
from beltsort.sorting.moving.reading import is_moving, moving_state_in
from beltsort.sorting.moving.report import MovingReport
from beltsort.sorting.record import progress_in
from beltsort.sorting.runs import LOCK
from beltsort.sorting.settling import Question, open_question, telling_entries


class Condition(StrEnum):
    """What has become of a run."""

    RUNNING = "running"
    HELD = "held"
    """It is held, whether its process waits or has ended."""
    FINISHED = "finished"
    STOPPED = "stopped"
    """Ended by a person, and can be resumed."""
    ABORTED = "aborted"
    """Ended by the emergency stop or by an unexpected error."""
    KILLED = "killed"
    """Its process is gone without having ended the run: killed, or the power failed."""


@dataclass(frozen=True)
class RunStatus:
    """The state of a run.

    Attributes
    ----------
    folder
        The run's.
    condition
        What has become of it.
    reason
        Why it is held, stopped or aborted; empty otherwise.
    pid
        The process that works on it; None if there is none.
    object
        Number of the object at the belt end; on a belt that never stops, of the first one that is undecided.
    objects
        Number of objects to sort; None: until the run is told to stop.
    left
        Number of objects that have not left the belt end; None if their number is not limited.
    bins
        Number of objects in each bin that has any, from the start of the run.
    skipped, passed
        Numbers of empty cups, and of objects that passed the belt end unsorted.
    steps
        Number of planner steps; on a belt that never stops, of scans.
    updated
        Time of the last entry, UTC, ISO 8601.
    question
        The question at which it is held; None if there is none.
    fates
        On a belt that never stops, the number of objects by how they left it; None on others.
    """

    folder: Path
    condition: Condition
    reason: str
    pid: int | None
    object: int
    objects: int | None
    left: int | None
    bins: dict[str, int]
    skipped: int
    passed: int
    steps: int
    updated: str
    question: Question | None
    fates: dict[str, int] | None = None


def status_of(folder: Path) -> RunStatus:
    """Return the state of a run; nothing is written.

    Parameters
    ----------
    folder
        The run's.

    Raises
    ------
    JournalError
        If there is no journal, or it is damaged.
    """
    used = in_use(folder / LOCK)  # before the entries: a run that ends in between has not been killed
    done = _done_moving(folder / JOURNAL) if is_moving(folder / JOURNAL) else _done(folder / JOURNAL)
    entries = list(telling_entries(folder / JOURNAL))
    _number, _object, updated = last_row(folder / JOURNAL)
    latest, ended = StateChanged(State.EXECUTE, ""), False
    for entry in entries:
        match entry.content:
            case StateChanged() as latest:
                pass
            case Started() | Resumed() | MovingStarted() | MovingResumed():
                ended = False
            case Ended():
                ended = True
    alive = used and not ended
    holder = holder_of(folder / LOCK) if alive else None
    state = latest.state
    running = state in (State.EXECUTE, State.COMPLETE)
    return RunStatus(
        folder,
        _condition(state, alive=alive, ended=ended),
        "" if running else in_words(latest.reason, latest.ways),
        None if holder is None else holder.pid,
        updated=updated,
        question=open_question(entries),
        **asdict(done),
    )


@dataclass(frozen=True)
class _Done:
    """What a run has done: attributes of `RunStatus`."""

    object: int
    objects: int | None
    left: int | None
    bins: dict[str, int]
    skipped: int
    passed: int
    steps: int
    fates: dict[str, int] | None = None


def _done(journal: Path) -> _Done:
    progress = progress_in(journal)
    counts = progress.counts
    if progress.bin is not None and progress.decisions:  # the object is being sorted
        counts = counts.with_decision(progress.decisions[-1], progress.model, -1)
    return _Done(
        progress.index,
        progress.objects,
        progress.left,
        counts.by_bin(progress.model.bins),
        counts.skipped,
        counts.passed,
        progress.steps,
    )


def _done_moving(journal: Path) -> _Done:
    state = moving_state_in(journal)
    report = MovingReport.of(state)
    bins = {name: n for name, n in zip(state.belt.model.bins, report.bins, strict=True) if n}
    empty = report.fates[Fate.EMPTY]
    return _Done(
        state.settled,
        state.objects,
        None if state.objects is None else state.objects - report.objects,
        bins,
        empty,
        report.objects - empty - report.fates[Fate.IN_BIN],
        state.scans,
        {str(fate): n for fate, n in report.fates.items()},
    )


def _condition(state: State, *, alive: bool, ended: bool) -> Condition:
    match state:
        case State.HELD if alive or ended:
            return Condition.HELD
        case State.COMPLETE:
            return Condition.FINISHED
        case State.STOPPED if ended:
            return Condition.STOPPED
        case State.ABORTED if ended:
            return Condition.ABORTED
    return Condition.RUNNING if alive else Condition.KILLED
