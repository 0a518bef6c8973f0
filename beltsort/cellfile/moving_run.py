"""Runs with the cell of a cell file whose belt never stops."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol, runtime_checkable

from beltsort import ArgumentError, ModelError, MovingBelt
from beltsort.cell.diverting import KnowsClassesAt
from beltsort.cell.wrappers.recorder import Recorded
from beltsort.cellfile.composed_moving import ComposedMovingCell, compose_moving
from beltsort.cellfile.description import CellDescription, contradictions
from beltsort.cellfile.ingredients import known_model, model_and_classifier, moving_policy_of
from beltsort.cellfile.problems import CellFileError
from beltsort.cellfile.run import check_ready
from beltsort.cellfile.run_folder import RunCalls, prune_for, write_about
from beltsort.perception import Classifier, perception_for
from beltsort.planning.policy import MovingPolicy
from beltsort.sim.prepare import StageProgress
from beltsort.sorting.heeding import Check, nothing
from beltsort.sorting.journal import Journal, Listeners
from beltsort.sorting.journal_files import JOURNAL
from beltsort.sorting.locks import devices_locked, locked
from beltsort.sorting.moving.entries import Looked
from beltsort.sorting.moving.loop import resume_moving, sort_moving
from beltsort.sorting.moving.reading import last_look, moving_state_in
from beltsort.sorting.moving.report import MovingReport
from beltsort.sorting.moving.state import MovingState
from beltsort.sorting.requests import drop_requests, taking_requests
from beltsort.sorting.runs import LOCK, MODEL, make_folder
from beltsort.tracking import TrackedPerception


@runtime_checkable
class EndsWithProcess(Protocol):
    """A device whose state is lost with the process, such as a simulated one."""

    def resume(self, state: MovingState, last: Looked) -> None:
        """Take the state of a run that is resumed, as of its last scan."""


@dataclass(frozen=True, eq=False)
class MovingRun:
    """A cell whose belt never stops, ready to sort.

    Attributes
    ----------
    description
        The cell file.
    cell
        The cell.
    belt
        Model, times and prices: those of the cell file, or of the run that is resumed.
    classifier
        That of the cell file, or a prepared one.
    policy, policy_name
        Chooses the actions; its name is kept in the run's folder.
    folder
        Folder of the run, created by `sort`.
    broken_off
        State of the run that is resumed; None for a new run.
    devices
        The devices without wrappers.
    """

    description: CellDescription
    cell: ComposedMovingCell
    belt: MovingBelt
    classifier: Classifier
    policy: MovingPolicy
    policy_name: str
    folder: Path
    broken_off: MovingState | None = None
    devices: Sequence[object] = ()

    @property
    def knows_classes(self) -> bool:
        """Whether the true classes of objects are known."""
        return any(isinstance(device, KnowsClassesAt) for device in self.devices)

    def sort(
        self, listener: Listeners = None, check: Check = nothing, *, allow_hold: bool = False
    ) -> MovingReport:
        """Sort the objects, or those that are left, and record every step in the journal.

        Parameters
        ----------
        listener
            Called with every entry of the journal; there may be several.
        check
            As in `beltsort.sorting.moving.loop.sort_moving`.
        allow_hold
            Whether a person can hold, continue and stop the run (`beltsort.sorting.requests`).

        Raises
        ------
        InUseError
            If another process uses the run or one of its devices.
        BeltsortError
            As in `beltsort.sorting.moving.loop.sort_moving`.
        """
        make_folder(self.folder)
        with locked(f"the run {self.folder}", self.folder / LOCK), devices_locked(self.devices):
            if not allow_hold:
                drop_requests(self.folder)
                return self._sort(listener, check, None)
            with taking_requests(self.folder):
                return self._sort(listener, check, self.folder)

    def _sort(self, listener: Listeners, check: Check, requests: Path | None) -> MovingReport:
        description = self.description
        assert description.moving is not None
        found = perception_for(self.belt.model, description.layout, self.classifier, description.perception)
        perception = TrackedPerception(found, exposure=description.moving.exposure)
        if self.broken_off is not None:
            with Journal(self.folder / JOURNAL, listener, resume=True) as journal:
                return resume_moving(
                    *(self.cell, perception, self.policy, journal),
                    rules=description.rules,
                    check=check,
                    requests=requests,
                )
        check_ready(self.cell)
        write_about(self.folder, description, self.policy_name)
        self.belt.model.save(self.folder / MODEL)
        prune_for(self.folder, description)
        with Journal(self.folder / JOURNAL, listener) as journal:
            return sort_moving(
                *(self.cell, perception, self.policy, self.belt, journal),
                objects=description.objects,
                rules=description.rules,
                check=check,
                requests=requests,
            )


def open_moving_run(
    description: CellDescription,
    runs: Path,
    *,
    live: bool,
    say: Callable[[str], None],
    progress: StageProgress | None = None,
    resume: Path | None = None,
    called: Callable[[Recorded], None] = lambda _recorded: None,
) -> MovingRun:
    """Create the devices, and load or prepare model and classifier.

    Parameters
    ----------
    description
        The cell file, with [moving].
    runs, live, say, progress, resume, called
        As in `beltsort.cellfile.run.open_run`.

    Raises
    ------
    CellFileError
        If back-ends, options or files do not fit the cell.
    BeltsortError
        If a file cannot be read.
    """
    moving = description.moving
    assert moving is not None
    if problems := list(contradictions(description)):  # options of a command change what the file says
        raise CellFileError(problems)
    broken_off = None if resume is None else moving_state_in(resume / JOURNAL)
    model, description = known_model(description, None if broken_off is None else broken_off.belt.model)
    calls = RunCalls(runs, resume, called)
    devices: list[object] = []
    cell = compose_moving(description, live=live, say=say, record=calls, made=devices.append)
    folder = calls.folder(dry_run=bool(cell.dry_run))
    model, classifier = model_and_classifier(description, model, progress)
    try:
        belt = moving.belt(model) if broken_off is None else broken_off.belt
    except (ArgumentError, ModelError) as reason:
        raise CellFileError.of("moving", str(reason)) from reason
    policy, name = moving_policy_of(description, belt, resume)
    last = None if resume is None else last_look(resume / JOURNAL)
    if broken_off is not None and last is not None:
        for device in devices:
            if isinstance(device, EndsWithProcess):
                device.resume(broken_off, last)
    return MovingRun(description, cell, belt, classifier, policy, name, folder, broken_off, devices)
