"""What the page shows, as plain data: a function of a run's history."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import isnan
from typing import Any

from beltsort import SortingModel
from beltsort.cell.commands import AdvanceTo, MoveTo, SortInto
from beltsort.planning.bins import Counts, sorting_statistics
from beltsort.planning.decisions import right_bins
from beltsort.planning.explanation import action_in_words
from beltsort.sorting.audit import action_of
from beltsort.sorting.entries import Chosen, Decided, Planned, State
from beltsort.sorting.report import REJECTED, Decision, confusion
from beltsort.sorting.run_state import Next
from beltsort.sorting.settling import Question
from beltsort.watch.base import Alarm, History
from beltsort.watch.history import Moment, RunHistory, ScanMark, most_likely

SHOWN_ALARMS = 50


@dataclass(frozen=True)
class PositionView:
    """A belt position: the number of its object (None beyond the last), what is believed and was seen."""

    object: int | None
    belief: list[float]
    likely: int | None
    """The class that is likelier than every other: an index."""
    bins: list[float]
    """Probability that each bin is right; empty if bins are the classes."""
    looks: int
    seen: str
    decided: str = ""
    """On a belt that never stops, the bin into which the object is decided; empty while it is not."""


@dataclass(frozen=True)
class ActionView:
    """An action that was compared, and its value."""

    name: str
    value: float
    chosen: bool


@dataclass(frozen=True)
class PlanView:
    """The choice of one planner step."""

    step: int
    action: str
    reason: str | None
    """Why a rule chose; None if the policy did."""
    values: list[ActionView]
    """The best first; empty if the policy compares none."""


@dataclass(frozen=True)
class BinView:
    """What a bin has received; right and purity are None where true classes are not known."""

    name: str
    objects: int
    right: int | None
    purity: float | None


@dataclass(frozen=True)
class TallyView:
    """What the run has come to."""

    sorted: int
    skipped: int
    passed: int
    forced: int | None
    """None on a belt that never stops, where no rule decides."""
    right: int | None
    looks_per_object: float | None
    objects_per_minute: float | None
    seconds: float
    bins: list[BinView]
    fates: dict[str, int] | None = None
    """Objects by how they left a belt that never stops; None on others."""
    uncounted: int = 0
    """Most objects that may have passed without a number."""


@dataclass(frozen=True)
class MomentView:
    """The run at one time."""

    step: int | None
    """The planner step before which this was; None for now."""
    time: str
    object: int
    """Number of the object at the belt end."""
    left: int
    """Number of objects that have left the belt."""
    viewpoint: int
    positions: list[PositionView]
    plan: PlanView | None
    doing: str
    """What is being done; empty unless this is now."""
    scan: ScanMark | None
    tally: TallyView


@dataclass(frozen=True)
class RunView:
    """A run, and the moment shown."""

    run: str
    state: str
    reason: str
    question: Question | None
    ended: str | None
    updated: str
    """Time of the last entry, UTC."""
    entry: int
    moving: bool
    """Whether the belt never stops."""
    objects: int | None
    first_step: int
    last_step: int
    classes: list[str]
    bins: list[str]
    viewpoints: list[str]
    alarms: list[Alarm]
    """The latest first."""
    alarm_counts: dict[str, int]
    moment: MomentView


def state_of(
    history: RunHistory, step: int | None = None, true: Mapping[int, int | None] | None = None
) -> RunView:
    """Return what is to be shown of a run.

    Parameters
    ----------
    history
        The run.
    step
        The planner step before which to show it; None: as it is now.
    true
        Class index of each object by its number, None for an empty cup, as far as known.

    Raises
    ------
    JournalError
        If the step is not among those kept.
    """
    progress = history.progress
    moment = history.moment(step)
    return run_view(
        history,
        progress.model,
        progress.run,
        progress.objects,
        MomentView(
            step=step,
            time=moment.time,
            object=moment.index,
            left=moment.index - progress.first,
            viewpoint=moment.viewpoint,
            positions=_positions(history, moment),
            plan=_plan(moment),
            doing=_doing(history) if step is None else "",
            scan=moment.scan,
            tally=_tally(history, moment, true or {}),
        ),
    )


def run_view(
    history: History[Any],
    model: SortingModel,
    run: str,
    objects: int | None,
    moment: MomentView,
    *,
    moving: bool = False,
) -> RunView:
    """Return what is to be shown of a run of either kind.

    Parameters
    ----------
    history
        The run.
    model
        Its model.
    run
        Its name.
    objects
        Number of objects to sort; None: until it is told to stop.
    moment
        The run at the time that is shown.
    moving
        Whether the belt never stops.
    """
    return RunView(
        run=run,
        state=history.state.value,
        reason=history.reason,
        question=history.question,
        ended=history.ended,
        updated=history.time,
        entry=history.last_entry,
        moving=moving,
        objects=objects,
        first_step=min(history.moments, default=0),
        last_step=max(history.moments, default=0),
        classes=model.classes,
        bins=model.bins,
        viewpoints=model.viewpoints,
        alarms=list(history.alarms)[: -SHOWN_ALARMS - 1 : -1],
        alarm_counts=dict(history.alarm_counts),
        moment=moment,
    )


def _positions(history: RunHistory, moment: Moment) -> list[PositionView]:
    model, end = history.progress.model, history.progress.end
    rows = moment.belief.probabilities
    bins = rows @ right_bins(model).T if model.bins != model.classes else rows[:, :0]  # (H, B)
    return [
        PositionView(
            object=moment.index + j if moment.index + j < end else None,
            belief=rounded(rows[j].tolist()),
            likely=most_likely(rows[j].tolist()),
            bins=rounded(bins[j].tolist()),
            looks=moment.looks[j],
            seen=moment.seen[j],
        )
        for j in range(len(rows))
    ]


def rounded(probabilities: Sequence[float]) -> list[float]:
    """Return probabilities with as many digits as the page needs."""
    return [round(p, 4) for p in probabilities]


def _plan(moment: Moment) -> PlanView | None:
    step = moment.step
    if step is None:
        return None
    values = action_views(step.choice, lambda action: action_in_words(step.model, action_of(action)))
    return PlanView(step.number, action_in_words(step.model, step.action), step.reason, values)


def action_views(
    choice: Planned | Chosen | Decided, name: Callable[[dict[str, Any]], str]
) -> list[ActionView]:
    """Return the actions that a planner has compared, the best first; none if another policy chose.

    Parameters
    ----------
    choice
        The choice of a step.
    name
        Returns the text of an action in the journal's format.
    """
    if not isinstance(choice, Planned):
        return []
    ranked = sorted(choice.values, key=lambda action: -action["value"])
    return [
        ActionView(name(action), round(action["value"], 3), choice.action.items() <= action.items())
        for action in ranked
    ]


def _doing(history: RunHistory) -> str:
    """Say what the run is doing now; nothing if it does nothing."""
    progress = history.progress
    if history.ended is not None or history.state is not State.EXECUTE or progress.done:
        return ""
    match progress.pending.act if progress.pending is not None else progress.next:
        case MoveTo(viewpoint):
            return f"moving to {progress.model.viewpoints[viewpoint]}"
        case AdvanceTo(index):
            return f"bringing object {index} to the belt end"
        case SortInto() | Next.ADVANCE:
            return "sorting the object at the belt end"
        case Next.SCAN:
            return f"scanning from {progress.model.viewpoints[progress.viewpoint]}"
    return "choosing the next action"


def _tally(history: RunHistory, moment: Moment, true: Mapping[int, int | None]) -> TallyView:
    progress = history.progress
    decisions = progress.decisions[: moment.sorted]
    done = moment.sorted + moment.skipped
    bins = _bins(progress.model, decisions, true)
    return TallyView(
        sorted=moment.sorted,
        skipped=moment.skipped,
        passed=moment.passed,
        forced=sum(decision.forced is not None for decision in decisions),
        right=sum(found.right or 0 for found in bins) if true else None,
        looks_per_object=sum(d.looks for d in decisions) / len(decisions) if decisions else None,
        objects_per_minute=60.0 * done / moment.seconds if done and moment.seconds > 0.0 else None,
        seconds=moment.seconds,
        bins=bins,
    )


def _bins(model: SortingModel, decisions: list[Decision], true: Mapping[int, int | None]) -> list[BinView]:
    """Return what each bin has received, the reject bin last if it has any."""
    objects = [0] * (len(model.bins) + 1)
    for decision in decisions:
        objects[-1 if decision.label is None else decision.label] += 1
    counts = confusion(((d.object, d.label) for d in decisions), true.get, model) if true else None
    views = bin_views(model, objects, counts)
    return [*views, BinView(REJECTED, objects[-1], None, None)] if objects[-1] else views


def bin_views(model: SortingModel, objects: Sequence[int], counts: Counts | None) -> list[BinView]:
    """Return what each bin of the model has received.

    Parameters
    ----------
    model
        The model, with L classes and B bins.
    objects
        Number of objects in each bin.
    counts
        Objects by bin and true class, uint64 of shape (B, L); None where classes are not known.
    """
    if counts is None:
        return [BinView(name, n, None, None) for name, n in zip(model.bins, objects, strict=False)]
    right = (counts * right_bins(model)).sum(axis=1).tolist()
    purities = [found.purity.value for found in sorting_statistics(model, counts).bins]
    return [
        BinView(name, objects[b], int(right[b]), None if isnan(purities[b]) else purities[b])
        for b, name in enumerate(model.bins)
    ]
