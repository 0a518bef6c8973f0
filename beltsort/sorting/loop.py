"""The loop: scan -> perceive -> belief -> plan -> act -> journal."""

from collections.abc import Callable
from dataclasses import asdict
from typing import Any
from uuid import uuid4

import beltsort
from beltsort._core import Despot, SortingModel
from beltsort.cell import Cell, EmergencyStopError
from beltsort.cell.commands import AdvanceTo, MoveTo, SortInto
from beltsort.cell.stopping import stopping
from beltsort.errors import CellError
from beltsort.planning.policy import Policy
from beltsort.sorting.choosing import Chooser
from beltsort.sorting.commander import Commander
from beltsort.sorting.entries import Drifted, Ended, Resumed, Started, State, StateChanged
from beltsort.sorting.holds import HeldError, Hold, Operator, nobody
from beltsort.sorting.journal import Journal
from beltsort.sorting.observing import Observer, Perceive, PerceivedPosition
from beltsort.sorting.progress import Next, Progress
from beltsort.sorting.record import Record, progress_in
from beltsort.sorting.report import SortingReport
from beltsort.sorting.rules import Drift, Rules
from beltsort.util.text import number_or_none

Check = Callable[[], None]


def nothing() -> None:
    """Check nothing."""


__all__ = ["Perceive", "PerceivedPosition", "resume_sorting", "sort_objects"]


def sort_objects(
    cell: Cell,
    perceive: Perceive,
    policy: Policy,
    model: SortingModel,
    journal: Journal,
    *,
    objects: int,
    first: int = 0,
    belt_ends: bool = False,
    rules: Rules | None = None,
    operator: Operator = nobody,
    drift: Drift | None = None,
    check: Check = nothing,
) -> SortingReport:
    """Sort the next objects of the belt, journalling every step.

    Parameters
    ----------
    cell
        Arm, camera, belt and bins; its classes, viewpoints and positions must be the model's. It needs no bin
        for the model's class for empty cups if that is the last one.
    perceive
        From a scan to one result per position, the belt end first.
    policy
        Names the next action.
    model
        Updates the belief.
    journal
        An open journal without entries. Its last entry is `end`, also after an error or an interrupt; after a
        kill or a power cut there is none.
    objects
        Objects to work through, empty cups included. An empty cup is skipped: when `Rules.empty_looks` says
        so or, if the model has a class for empty cups, when that is decided.
    first
        Number of the object at the belt end now, as the belt counts.
    belt_ends
        Whether nothing follows these objects. The policy is then asked with beliefs that know how many
        are left (`Belief.remaining`); planners look longer at the last ones, as nothing waits behind them.
    rules
        Limits; default `Rules()`.
    operator
        Asked what became of a command where no device can tell; by default the run ends as held.
    drift
        Watch whether labels still come as the tables say; not by default. Alarms are journalled.
    check
        Called before every step; what it raises ends the run, as an interrupt does. An exception that a
        signal handler raises may be swallowed by the library it interrupts: a flag that is read here is not.

    Raises
    ------
    CellError
        If cell and model do not fit, the camera gives no usable scan or stands elsewhere, a command cannot be
        carried out, or the tables no longer hold and `Drift.hold` says so;
        `resume_sorting` goes on once that is mended.
    HeldError
        If a person must say what became of a command.
    BeltsortError
        Whatever else the cell, perception or the policy raise.
    """
    record = Record(journal, Progress.at_start(model))
    loop = _Loop(cell, perceive, policy, record, rules or Rules(), operator, drift, check)
    return loop.run(
        Started(
            run=uuid4().hex[:8],
            first=first,
            objects=objects,
            belt_ends=belt_ends,
            model=model.to_json(),
            planner=_settings(policy),
            beltsort=beltsort.__version__,
            drift=None if drift is None else asdict(drift),
        )
    )


def resume_sorting(
    cell: Cell,
    perceive: Perceive,
    policy: Policy,
    journal: Journal,
    *,
    rules: Rules | None = None,
    operator: Operator = nobody,
    drift: Drift | None = None,
    check: Check = nothing,
) -> SortingReport:
    """Go on with a run that was broken off, wherever that was.

    The belief is exactly the one that the run had. A command whose outcome was not written down is settled
    first: a sort is repeated only if its device says that it was not done. The camera is brought back to
    where it stood, which counts as no step.

    Parameters
    ----------
    cell, perceive, policy, rules, operator, drift, check
        As in `sort_objects`; the same as before, if the decisions are to be the same.
    journal
        The run's journal, opened with ``resume=True``.

    Returns
    -------
    SortingReport
        Of the whole run, as far as the journal still has it.

    Raises
    ------
    JournalError
        If the journal is damaged.
    BeltsortError
        As `sort_objects`.
    """
    record = Record(journal, progress_in(journal.path))
    loop = _Loop(cell, perceive, policy, record, rules or Rules(), operator, drift, check)
    return loop.run(
        Resumed(
            objects=record.progress.objects,
            model=record.progress.model.to_json(),
            planner=_settings(policy),
            beltsort=beltsort.__version__,
            drift=None if drift is None else asdict(drift),
        )
    )


class _Loop:
    def __init__(
        self,
        cell: Cell,
        perceive: Perceive,
        policy: Policy,
        record: Record,
        rules: Rules,
        operator: Operator,
        drift: Drift | None,
        check: Check,
    ) -> None:
        self.cell, self.record, self.progress, self.drift = cell, record, record.progress, drift
        self.check = check
        _check_fit(cell, self.progress.model)
        self.commander = Commander(cell, self.progress, record, rules, operator)
        self.observer = Observer(cell, perceive, self.progress, record, rules)
        self.chooser = Chooser(cell, policy, record, rules, self.commander)

    def run(self, first: Started | Resumed) -> SortingReport:
        """Work until nothing is left, from a first entry on; write down how it ends.

        What ends it early stops every device.
        """
        try:
            with stopping(self.cell):
                self.record(first)
                self.record(StateChanged(State.EXECUTE, first.kind))
                while not self.progress.done:
                    self.check()
                    self.step()
        except BaseException as failure:
            self.record(StateChanged(_state_after(failure), repr(failure)))
            self.record(Ended(repr(failure)))
            raise
        self.record(StateChanged(State.COMPLETE, "all objects have left the belt"))
        self.record(Ended("done"))
        progress = self.progress
        return SortingReport(
            progress.steps,
            tuple(progress.decisions),
            tuple(progress.skipped),
            progress.drift.alarms,
            tuple(progress.passed),
        )

    def step(self) -> None:
        """Do what comes next: what a run was broken off in first, and nothing before the camera stands."""
        progress = self.progress
        if progress.drift.unreported:
            self.report_drift()
        elif progress.pending is not None:
            self.commander.settle(progress.pending)
        elif not progress.arrived:
            self.commander.issue(MoveTo(progress.viewpoint), arriving=True)
        elif progress.next is Next.SCAN:
            self.observer.observe()
        elif progress.bin is not None:
            self.commander.issue(SortInto(progress.bin))
        elif progress.next is Next.ADVANCE:
            self.commander.issue(AdvanceTo(progress.index + 1))
        else:
            self.chooser.choose()

    def report_drift(self) -> None:
        """Write down the alarms of the watch over the tables, and hold the run if it is to be held."""
        for alarm in self.progress.drift.unreported:
            evidence = number_or_none(alarm.evidence)
            self.record(Drifted(alarm.position, alarm.viewpoint, alarm.looks, evidence))
        if self.drift is not None and self.drift.hold:
            alarms = len(self.progress.drift.alarms)
            reason = (
                f"{alarms} drift alarms, expected none while drift.hold is on: labels no longer come as the "
                "tables say; look at camera, classifier and objects, and estimate the tables anew, or go on "
                "with these"
            )
            raise HeldError(Hold(None, reason, person=True))


def _state_after(failure: BaseException) -> State:
    """Return the state in which a run ends early: held if it can go on once the cell has been seen to."""
    match failure:
        case EmergencyStopError():
            return State.ABORTED
        case CellError():
            return State.HELD
        case KeyboardInterrupt():
            return State.STOPPED
        case _:
            return State.ABORTED


def _settings(policy: Policy) -> dict[str, Any] | None:
    return policy.settings if isinstance(policy, Despot) else None


def _check_fit(cell: Cell, model: SortingModel) -> None:
    classes = list(model.classes)
    if classes[-1] == model.empty and model.empty not in cell.classes:
        classes.pop()
    pairs: list[tuple[str, Any, Any]] = [
        ("classes", list(cell.classes), classes),
        ("viewpoints", list(cell.viewpoints), list(model.viewpoints)),
        ("positions", cell.layout.positions, model.positions),
    ]
    for name, of_cell, of_model in pairs:
        if of_cell != of_model:
            raise CellError(
                f"the cell's {name} are {of_cell}, the model's {of_model}; they must agree, in order: "
                "estimate the tables with this cell"
            )
