"""The sorting loop: scan, perceive, update the belief, plan, act. Every step is journalled."""

from dataclasses import asdict
from pathlib import Path
from typing import Any
from uuid import uuid4

import beltsort
from beltsort._core import Despot, SortingModel
from beltsort.cell import Cell
from beltsort.cell.commands import AdvanceTo, MoveTo, SortInto
from beltsort.planning.policy import Policy
from beltsort.sorting.choosing import Chooser
from beltsort.sorting.commander import Commander
from beltsort.sorting.ending import sort_to_end
from beltsort.sorting.entries import Drifted, Resumed, Started
from beltsort.sorting.fit import check_fit
from beltsort.sorting.heeding import Check, Heeding, nothing
from beltsort.sorting.holds import HeldError, Hold, Operator, nobody
from beltsort.sorting.journal import Journal
from beltsort.sorting.kept_scans import ScanListener
from beltsort.sorting.observing import Observer
from beltsort.sorting.perceived import NamesLabels, Perceive, PerceivedPosition
from beltsort.sorting.progress import Progress
from beltsort.sorting.record import Record
from beltsort.sorting.report import SortingReport
from beltsort.sorting.rules import Drift, Rules
from beltsort.sorting.run_state import Next
from beltsort.util.text import number_or_none

__all__ = ["NamesLabels", "Perceive", "PerceivedPosition", "resume_sorting", "sort_objects"]


def sort_objects(
    cell: Cell,
    perceive: Perceive,
    policy: Policy,
    model: SortingModel,
    journal: Journal,
    *,
    objects: int | None,
    first: int = 0,
    belt_ends: bool = False,
    rules: Rules | None = None,
    operator: Operator = nobody,
    drift: Drift | None = None,
    check: Check = nothing,
    requests: Path | None = None,
    scan_listener: ScanListener | None = None,
) -> SortingReport:
    """Sort the next objects of the belt, journalling every step.

    Parameters
    ----------
    cell
        Arm, camera, belt and sorter; its classes, bins, viewpoints and positions must be the model's, in
        order. If the last class of the model stands for empty cups, the cell needs neither this class nor a
        last bin of its name.
    perceive
        Function from a scan to one result per position, the belt end first. Its labels are found among the
        model's by their names (`NamesLabels`); if it does not name them, they are the model's classes.
    policy
        Chooses the next action.
    model
        The model with which the belief is updated.
    journal
        An open journal without entries. The last entry written is `end`, also after an error or an interrupt;
        it is missing only after a kill or a power failure.
    objects
        Number of objects to sort, empty cups included; None: until a request to stop (`requests`). A cup is
        skipped once it has been seen empty `Rules.empty_looks` times or, if the model has a class for empty
        cups, once the bin of its name is decided.
    first
        The belt's number of the object at the belt end now.
    belt_ends
        Whether no objects follow these. The beliefs given to the policy then include the number of objects
        left (`Belief.remaining`), and planners spend more looks on the last ones, which delay no others.
    rules
        Limits; default `Rules()`.
    operator
        Asked for the outcome of a command if no device knows it; by default nobody is asked, and the run is
        held.
    drift
        Settings of drift detection; off by default. Alarms are journalled.
    check
        Called before every step; an exception that it raises ends the run, as an interrupt does. Signal
        handlers should set a flag that is checked here, since an exception raised in a handler may be lost in
        the library that it interrupts.
    requests
        Folder in which `beltsort.sorting.requests` leaves requests to hold the run and to continue it, which
        are read before every step; by default it takes none.
    scan_listener
        Called with every scan that was used.

    Returns
    -------
    SortingReport
        Steps, decisions and skipped cups.

    Raises
    ------
    CellError
        If cell and model do not fit, the camera returns no usable scan or is not at its viewpoint, a command
        fails, or labels have drifted and `Drift.hold` is set. When the cause has been removed,
        `resume_sorting` continues the run.
    HeldError
        If an operator must say whether a command was done.
    BeltsortError
        Any other error of the cell, of perception or of the policy.
    """
    record = Record(journal, Progress.at_start(model))
    watching = check, requests, scan_listener
    loop = _Loop(cell, perceive, policy, record, rules or Rules(), operator, drift, *watching)
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
    requests: Path | None = None,
    scan_listener: ScanListener | None = None,
) -> SortingReport:
    """Continue an interrupted run from its journal.

    The belief is restored exactly. If the outcome of the last command was not journalled, it is established
    first; a sort is repeated only if the device says that it was not done. The camera is moved back to its
    viewpoint, which does not count as a step.

    Parameters
    ----------
    cell, perceive, policy, rules, operator, drift, check, requests, scan_listener
        As in `sort_objects`; for the same decisions, they must be the same as before.
    journal
        The run's journal, opened with ``resume=True``.

    Returns
    -------
    SortingReport
        The whole run, as far as it is still in the journal.

    Raises
    ------
    JournalError
        If the journal is damaged.
    BeltsortError
        As `sort_objects`.
    """
    record = Record.resumed(journal)
    watching = check, requests, scan_listener
    loop = _Loop(cell, perceive, policy, record, rules or Rules(), operator, drift, *watching)
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
        requests: Path | None,
        scan_listener: ScanListener | None,
    ) -> None:
        self.cell, self.record, self.progress, self.drift = cell, record, record.progress, drift
        self.check, self.heed = check, Heeding(requests, record, check)
        check_fit(cell, self.progress.model)
        self.commander = Commander(cell, self.progress, record, rules, operator, check)
        self.observer = Observer(cell, perceive, self.progress, record, rules, scan_listener)
        self.chooser = Chooser(cell, policy, record, rules, self.commander)

    @property
    def done(self) -> bool:
        """Whether all objects have left the belt."""
        return self.progress.done

    def run(self, first: Started | Resumed) -> SortingReport:
        """Write the first entry, take steps until all objects have left the belt, and journal how it ended.

        A request to stop ends the run between two steps. If a failure does, every device is stopped.
        """
        stop = sort_to_end(self.record, first, self.cell, self)
        progress = self.progress
        return SortingReport(
            progress.steps,
            tuple(progress.decisions),
            tuple(progress.skipped),
            progress.counts,
            progress.drift.alarms,
            tuple(progress.passed),
            dict(progress.pose_faults),
            stopped_by=None if stop is None else stop.by,
        )

    def step(self) -> None:
        """Take the next step; a pending command and the camera's return to its viewpoint come first."""
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
        """Journal new drift alarms, and hold the run if `Drift.hold` is set."""
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


def _settings(policy: Policy) -> dict[str, Any] | None:
    """Return what the journal keeps of a policy: the settings of `Despot`, nothing of others."""
    return policy.settings if isinstance(policy, Despot) else None
