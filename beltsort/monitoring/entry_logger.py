"""Journal entries as records of `logging`."""

import logging

from beltsort.cell.commands import MoveTo
from beltsort.sorting.command import Command
from beltsort.sorting.entries import (
    Answered,
    AnyContent,
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
    State,
    StateChanged,
    Unheard,
)
from beltsort.sorting.entry_text import EntryFormatter, in_words
from beltsort.sorting.journal import Entry
from beltsort.sorting.moving.entries import (
    Anchored,
    DiversionTold,
    Diverting,
    EncoderJumped,
    Fate,
    FoundEmpty,
    Looked,
    MovingResumed,
    MovingSnapshot,
    MovingStarted,
    ObjectLeft,
)
from beltsort.sorting.moving.state import MovingState
from beltsort.sorting.progress import Progress

LOGGER = "beltsort.run"
"""Name of the logger of a run's entries."""

log = logging.getLogger(LOGGER)

IN_GOOD_ORDER = ("done", "stopped")
"""The reason with which a run ends after its last object."""


class EntryLogger:
    """A listener of the journal that logs its entries.

    Attributes
    ----------
    run
        Name of the run; None before the first entry.
    step
        Number of the planner step, from 1; None before the first, and on a belt that never stops.
    object
        Number of the object at the belt end; on a belt that never stops, of the first one that is undecided.
    """

    def __init__(self) -> None:
        self.run: str | None = None
        self.step: int | None = None
        self.object: int | None = None
        self._done = 0  # steps that have ended
        self._pending: Command | None = None
        self._moving = False  # whether the belt never stops; its runs have no steps
        self._formatter = EntryFormatter()

    def resume(self, progress: Progress | MovingState) -> None:
        """Continue with a run that is resumed, whose entries do not say where it was."""
        if isinstance(progress, MovingState):
            self.run, self.object, self._moving = progress.run, progress.settled, True
            return
        self.run, self.object = progress.run, progress.index
        self._done, self._pending = progress.steps, progress.pending
        self.step = progress.steps or None

    def __call__(self, entry: Entry) -> None:
        """Log an entry."""
        content = entry.content
        self.object = entry.object
        self._place(content)
        text = self._formatter.text(entry)
        level = level_of(content)
        if log.isEnabledFor(level):
            message = _text_of(content) if text is None else text
            log.log(level, "%s", message, extra={"kind": entry.kind, "entry": entry.number})

    def _place(self, content: AnyContent) -> None:
        """Update run and step."""
        match content:
            case Started(run=run):
                self.run = run
            case MovingStarted(run=run) | MovingSnapshot(run=run):
                self.run, self._moving = run, True
            case Snapshot(run=run, steps=steps):
                self.run, self._done = run, steps
            case Intended(command):
                self._pending = command
            case CommandDone():
                done, self._pending = self._pending, None
                moved = done is not None and isinstance(done.act, MoveTo) and not done.arriving
                self._done += int(moved)
            case Planned() | Chosen() if not self._moving:
                self.step = self._done + 1
            case Decided() | Skipped(decided=True):
                self.step = self._done = self._done + 1


def level_of(content: AnyContent) -> int:
    """Return the level at which an entry is logged.

    Examples
    --------
    >>> level_of(Ended("done")) == logging.INFO
    True
    >>> level_of(ScanUnusable("no point in it")) == logging.WARNING
    True
    """
    match content:
        case ObjectLeft(fate=fate):
            return logging.INFO if fate in (Fate.IN_BIN, Fate.EMPTY) else logging.WARNING
        case DiversionTold(state=told):
            return logging.DEBUG if told in ("queued", "done") else logging.WARNING
        case EncoderJumped():
            return logging.WARNING
        case Looked() | FoundEmpty() | Diverting():
            return logging.DEBUG
        case Anchored(uncounted=uncounted):
            return logging.WARNING if uncounted else logging.INFO
        case MovingStarted() | MovingResumed() | MovingSnapshot():
            return logging.INFO
        case StateChanged(State.ABORTED):
            return logging.ERROR
        case Ended(reason):
            return logging.INFO if reason in IN_GOOD_ORDER else logging.ERROR
        case StateChanged(State.HELD) | CommandFailed() | ObjectsPassed() | Unheard():
            return logging.WARNING
        case ScanUnusable() | ScanElsewhere() | Drifted():
            return logging.WARNING
        case Planned(late=late):
            return logging.WARNING if late else logging.DEBUG
        case Scanned(dropped=dropped, pose_fault=fault):
            return logging.WARNING if dropped or fault is not None else logging.DEBUG
        case Decided(forced=forced):
            return logging.INFO if forced is None else logging.WARNING
        case Intended(command):
            return logging.DEBUG if command.attempt == 1 else logging.INFO
        case Chosen() | CommandDone():
            return logging.DEBUG
        case Started() | Resumed() | StateChanged() | Answered() | Settled() | Skipped() | Requested():
            return logging.INFO
        case Snapshot():
            return logging.INFO


def _text_of(content: AnyContent) -> str:
    """Return the text of an entry that a run does not display."""
    match content:
        case Planned(action=action, trials=trials, seconds=seconds, late=late):
            than = ", longer than its budget" if late else ""
            return f"planned {_action(action)}: {trials} trials in {seconds:.3f} s{than}"
        case Chosen(action=action, why=why):
            return f"chosen {_action(action)}" + (f": {why}" if why else "")
        case Intended(command):
            return f"{command.act}: command {command.id}"
        case CommandDone(command_id):
            return f"{command_id} done"
        case Answered(command_id, outcome):
            return f"the operator says: {command_id} {outcome}"
        case Settled(answer, by):
            return f"answered: {answer}, says {by}"
        case ObjectsPassed(index):
            return f"the operator says: objects passed unsorted, object {index} is at the belt end"
        case StateChanged(state, reason):
            return f"state {state}: {in_words(reason)}"
        case Requested(action, by):
            return f"{by} asked to {action}"
        case Unheard(error):
            return f"a listener failed and is not called again: {error}"
        case Snapshot():
            return "the journal goes on in a new file"
        case Ended(reason):
            return f"ended: {in_words(reason)}"
        case other:
            return other.kind


def _action(action: dict[str, int]) -> str:
    return ", ".join(f"{verb} {target}" for verb, target in action.items())
