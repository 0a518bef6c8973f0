"""Runs on a belt that never stops: the state before each planner step, and what the page shows of it."""

from dataclasses import dataclass, replace

import numpy as np

from beltsort.cell.commands import MoveTo
from beltsort.planning.decisions import class_probabilities, right_bins
from beltsort.sorting.entries import Chosen, CommandDone, CommandFailed, Intended, Planned, State
from beltsort.sorting.journal import Entry
from beltsort.sorting.moving.entries import (
    Anchored,
    BeltObject,
    DiversionTold,
    Diverting,
    EncoderJumped,
    Fate,
    FoundEmpty,
    Looked,
    ObjectLeft,
)
from beltsort.sorting.moving.report import MovingReport
from beltsort.sorting.moving.state import MovingState
from beltsort.watch.base import History
from beltsort.watch.history import ScanMark, most_likely
from beltsort.watch.state import (
    MomentView,
    PlanView,
    PositionView,
    RunView,
    TallyView,
    action_views,
    bin_views,
    rounded,
    run_view,
)

SORTED = (Fate.IN_BIN, Fate.EMPTY)
"""How objects leave that need not come again: those that count as objects per minute."""


@dataclass(frozen=True, eq=False)
class MovingMoment:
    """The state of a run when the action of a step was chosen, or after the last entry.

    Attributes
    ----------
    time, seconds
        As in `beltsort.watch.history.Moment`.
    step, choice
        Number of the step, and its entry's content; None before the first.
    state
        What the run knew.
    exit
        Number of the object at the exit, as far as the journal tells; no larger than it was.
    seen
        The last label of each object on the belt, or why there was none, by number.
    decisions, looks
        Number of diversions that were ordered, and of looks at those objects.
    scan
        None: such runs keep no scans.
    """

    time: str
    seconds: float
    step: int | None
    choice: Planned | Chosen | None
    state: MovingState
    exit: int
    seen: dict[int, str]
    decisions: int
    looks: int
    scan: ScanMark | None = None


class MovingHistory(History[MovingMoment]):
    """Reads the entries of a run on a belt that never stops, one after the other; see `History`.

    Planner steps are counted from the first one that the journal still has.

    Attributes
    ----------
    progress
        The state after the last entry.
    sorted_before
        Objects that had left in one of the ways `SORTED` before the first entry.
    """

    def __init__(self, first: Entry) -> None:
        super().__init__(first)
        self.progress = MovingState.after([first])
        self.sorted_before = sorted_of(self.progress)
        self._exit = self.progress.watched_exit
        self._seen: dict[int, str] = {}
        self._step: int | None = None
        self._choice: Planned | Chosen | None = None
        self._acting = False  # whether the action of the last step goes on
        self._moving_to: int | None = None
        self._decisions = self._looks = 0

    def now(self) -> MovingMoment:
        """Return the state after the last entry."""
        return MovingMoment(
            self.time,
            self.seconds,
            self._step,
            self._choice,
            self.progress.copy(),
            self._exit,
            dict(self._seen),
            self._decisions,
            self._looks,
        )

    def follow(self, entry: Entry) -> None:
        """Apply an entry to the state, and keep the state before a planner step."""
        content = entry.content
        if isinstance(content, Planned | Chosen):
            self._step, self._choice, self._acting = (self._step or 0) + 1, content, True
            self.keep(self._step, self.now())
        self.progress.apply(content)
        match content:
            case Intended(command) if isinstance(command.act, MoveTo):
                self._moving_to = command.act.viewpoint
            case CommandDone() | CommandFailed():
                self._moving_to = None
            case Looked() as look:
                self._acting, self._exit = False, self.progress.watched_exit
                seen = zip(look.seen, self.names.seen(look), strict=True)
                self._seen |= {each.number: text for each, text in seen}
            case Diverting(number=number, looks=looks):
                self._decisions, self._looks = self._decisions + 1, self._looks + looks
                self._place(number)
            case FoundEmpty(number):
                self._place(number)
            case ObjectLeft(number):
                self._seen.pop(number, None)
                self._exit = max(self._exit, number + 1)

    def note(self, entry: Entry, text: str) -> None:
        """Keep what an entry says about the state of the run, and what is an alarm, before it is applied."""
        super().note(entry, text)
        match entry.content:
            case ObjectLeft(fate=fate) if fate not in SORTED:
                self.alarm(entry, str(fate), text)
            case EncoderJumped():
                self.alarm(entry, "encoder", text)
            case Anchored() if self.progress.lattice is not None:
                self.alarm(entry, "restart", f"the belt's controller was restarted: {text}")
            case DiversionTold(retry=True):
                self.alarm(entry, "refused", text)

    def doing(self) -> str:
        """Say what the run is doing now; nothing if it does nothing."""
        if self.ended is not None or self.state is not State.EXECUTE or self.progress.done:
            return ""
        if self._moving_to is not None:
            return f"moving to {self.names.viewpoints[self._moving_to]}"
        action = self._choice.action if self._acting and self._choice is not None else {}
        if "move" in action:
            return f"scanning from {self.names.viewpoints[self.progress.viewpoint]}"
        if "wait" in action:
            return "waiting"
        return "choosing the next action"

    def _place(self, number: int) -> None:
        """Note from a decision about an object which one was at the exit when it was chosen."""
        self._acting = False
        if self._step is None or self._choice is None or "position" not in self._choice.action:
            return
        self._exit = number - self._choice.action["position"]
        if self._step in self.moments:
            self.moments[self._step] = replace(self.moments[self._step], exit=self._exit)


def moving_state_of(history: MovingHistory, step: int | None = None) -> RunView:
    """Return what is to be shown of a run on a belt that never stops.

    Parameters
    ----------
    history
        The run.
    step
        The planner step before which to show it; None: as it is now.

    Raises
    ------
    JournalError
        If the step is not among those kept.
    """
    moment = history.moment(step)
    state = moment.state
    return run_view(
        history,
        state.belt.model,
        state.run,
        state.objects,
        MomentView(
            step=step,
            time=moment.time,
            object=moment.exit,
            left=sum(state.fates.values()),
            viewpoint=state.viewpoint,
            positions=_positions(moment),
            plan=_plan(history, moment),
            doing=history.doing() if step is None else "",
            scan=moment.scan,
            tally=_tally(history, moment),
        ),
        moving=True,
    )


def sorted_of(state: MovingState) -> int:
    """Return how many objects have left in one of the ways `SORTED`."""
    return sum(state.fates.get(fate, 0) for fate in SORTED)


def _positions(moment: MovingMoment) -> list[PositionView]:
    state = moment.state
    model = state.belt.model
    right = right_bins(model) if model.bins != model.classes else None
    views = []
    for number in range(moment.exit, moment.exit + model.positions):
        known = state.known(number)
        classes = class_probabilities(model, known.kinds)
        tracked = state.lattice is not None and (state.objects is None or number < state.objects)
        views.append(
            PositionView(
                object=number if tracked else None,
                belief=rounded(classes),
                likely=most_likely(classes),
                bins=[] if right is None else rounded((right @ np.array(classes)).tolist()),
                looks=known.looks,
                seen=moment.seen.get(number, ""),
                decided=_decided(state, known),
            )
        )
    return views


def _decided(state: MovingState, known: BeltObject) -> str:
    if known.skipped:
        return "empty cup"
    return "" if known.bin is None else state.belt.model.bins[known.bin]


def _plan(history: MovingHistory, moment: MovingMoment) -> PlanView | None:
    choice = moment.choice
    if choice is None or moment.step is None:
        return None
    name = history.names.name
    reason = choice.why if isinstance(choice, Chosen) else None
    return PlanView(moment.step, name(choice.action), reason, action_views(choice, name))


def _tally(history: MovingHistory, moment: MovingMoment) -> TallyView:
    state = moment.state
    report = MovingReport.of(state)
    counts = np.array(report.confusion, dtype=np.uint64)
    known = bool(counts.any())
    bins = bin_views(state.belt.model, report.bins, counts if known else None)
    done = sorted_of(state) - history.sorted_before
    return TallyView(
        sorted=report.fates[Fate.IN_BIN],
        skipped=report.fates[Fate.EMPTY],
        passed=report.objects - sorted_of(state),
        forced=None,
        right=sum(found.right or 0 for found in bins) if known else None,
        looks_per_object=moment.looks / moment.decisions if moment.decisions else None,
        objects_per_minute=60.0 * done / moment.seconds if done and moment.seconds > 0.0 else None,
        seconds=moment.seconds,
        bins=bins,
        fates={str(fate): number for fate, number in report.fates.items()},
        uncounted=report.uncounted,
    )
