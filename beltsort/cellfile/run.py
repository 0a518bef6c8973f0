"""Runs with the cell of a cell file."""

from collections.abc import Callable, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path

from beltsort import SortingModel
from beltsort.cell.commands import CommandError, EmergencyStopError, Outcome
from beltsort.cell.protocols import NOWHERE, Homing, KnowsClasses, Restorable, TellsPosition
from beltsort.cell.wrappers.recorder import Recorded
from beltsort.cellfile.check import CellCheck, ask_health
from beltsort.cellfile.composed import ComposedCell, compose
from beltsort.cellfile.composed_moving import ComposedMovingCell
from beltsort.cellfile.description import CellDescription
from beltsort.cellfile.ingredients import known_model, model_and_classifier, policy_of
from beltsort.cellfile.run_folder import RunCalls, prune_for, write_about
from beltsort.errors import CellError
from beltsort.perception import Classifier, perception_for
from beltsort.planning.policy import Policy
from beltsort.rrd import Recorder
from beltsort.sim.prepare import StageProgress
from beltsort.sorting.heeding import Check, nothing
from beltsort.sorting.holds import NUMBER, HeldError, Hold, Operator, Way, nobody
from beltsort.sorting.journal import Journal, Listeners, listeners_of
from beltsort.sorting.journal_files import JOURNAL
from beltsort.sorting.kept_scans import ScanKeeper, ScanListener, all_of
from beltsort.sorting.locks import devices_locked, locked
from beltsort.sorting.loop import resume_sorting
from beltsort.sorting.progress import Progress
from beltsort.sorting.record import progress_in
from beltsort.sorting.report import SortingReport
from beltsort.sorting.requests import drop_requests, taking_requests
from beltsort.sorting.runs import (
    LOCK,
    make_folder,
    sort_into,
    write_true_classes,
)


@dataclass(frozen=True, eq=False)
class CellRun:
    """A cell that is ready to sort.

    Attributes
    ----------
    description
        The cell file.
    cell
        The cell.
    model, classifier
        Those of the cell file, or prepared ones.
    policy, policy_name
        Chooses the actions; its name is kept in the run's folder.
    folder
        Folder of the run, created by `sort`.
    broken_off
        Progress of the run that is resumed; None for a new run.
    first
        Number of the object at the belt end as given by an operator; None: the belt is asked.
    devices
        The devices without wrappers.
    """

    description: CellDescription
    cell: ComposedCell
    model: SortingModel
    classifier: Classifier
    policy: Policy
    policy_name: str
    folder: Path
    broken_off: Progress | None = None
    first: int | None = None
    devices: Sequence[object] = ()

    @property
    def homable(self) -> bool:
        """Whether there is a belt that can be homed."""
        return any(isinstance(device, Homing) for device in self.devices)

    def sort(
        self,
        listener: Listeners = None,
        operator: Operator = nobody,
        check: Check = nothing,
        *,
        allow_hold: bool = False,
        recorder: Recorder | None = None,
        scan_listener: ScanListener | None = None,
    ) -> SortingReport:
        """Sort the objects, or those that are left, and record every step in the journal.

        All devices are stopped if the run ends early. `listener` is called with every entry of the
        journal; there may be several, and one that fails is not called again. `operator` and `check` are as
        in `beltsort.sorting.loop.sort_objects`. `allow_hold` makes a token with which a person can hold and
        continue the run (`beltsort.sorting.requests`); a run without it goes on after an earlier hold. A
        `recorder` writes a recording for the rerun viewer; `scan_listener` is called with every scan that was
        used.

        Raises
        ------
        InUseError
            If another process uses the run or one of its devices.
        HeldError
            If the belt of a new run does not know its position, and no operator has given it.
        BeltsortError
            As in `beltsort.sorting.loop.sort_objects`.
        """
        make_folder(self.folder)
        run = locked(f"the run {self.folder}", self.folder / LOCK)
        with run, devices_locked(self.devices), recorder or nullcontext():
            if not allow_hold:
                drop_requests(self.folder)
                return self._sort(listener, operator, check, None, recorder, scan_listener)
            with taking_requests(self.folder):
                return self._sort(listener, operator, check, self.folder, recorder, scan_listener)

    def _sort(
        self,
        listener: Listeners,
        operator: Operator,
        check: Check,
        requests: Path | None,
        recorder: Recorder | None,
        scan_listener: ScanListener | None,
    ) -> SortingReport:
        heard_by = (recorder, *listeners_of(listener))
        scan_listener = all_of(None if recorder is None else recorder.scanned, scan_listener)
        description = self.description
        settings = description.perception
        perception = perception_for(self.model, description.layout, self.classifier, settings)
        if self.broken_off is not None:
            with Journal(self.folder / JOURNAL, heard_by, resume=True) as journal:
                return resume_sorting(
                    *(self.cell, perception, self.policy, journal),
                    rules=description.rules,
                    operator=operator,
                    drift=description.drift,
                    check=check,
                    requests=requests,
                    scan_listener=all_of(
                        ScanKeeper(self.folder, self.cell, description.rules.kept_scans), scan_listener
                    ),
                )
        first = self._first_object()
        check_ready(self.cell)
        write_about(self.folder, description, self.policy_name)
        true = true_class_of(self.devices)
        if true is not None and description.objects is not None:
            write_true_classes(self.folder, first, [true(first + n) for n in range(description.objects)])
        prune_for(self.folder, description)
        return sort_into(
            self.folder,
            self.cell,
            perception,
            self.policy,
            self.model,
            objects=description.objects,
            first=first,
            belt_ends=description.belt_ends,
            rules=description.rules,
            operator=operator,
            drift=description.drift,
            listener=heard_by,
            check=check,
            requests=requests,
            scan_listener=scan_listener,
        )

    def _first_object(self) -> int:
        """Return the number of the object at the belt end, with which a new run starts."""
        beginning = Progress.at_start(self.model)
        if self.first is not None:
            beginning.index = beginning.first = self.first
            restore(self.devices, beginning)
        beginning.index = beginning.first = first_object(self.cell, self.devices, self.first)
        restore(self.devices, beginning)
        return beginning.first


def open_run(
    description: CellDescription,
    runs: Path,
    *,
    live: bool,
    say: Callable[[str], None],
    progress: StageProgress | None = None,
    resume: Path | None = None,
    first: int | None = None,
    called: Callable[[Recorded], None] = lambda _recorded: None,
) -> CellRun:
    """Create the devices, and load or prepare model and classifier.

    Parameters
    ----------
    description
        The cell file.
    runs
        Folder of all runs.
    live
        Whether commands are sent to devices that can move hardware; otherwise the run is a dry run, and its
        folder's name ends in `DRY_RUN`.
    say
        Called with a line for each command in a dry run.
    progress
        Called with each stage of `prepare`.
    resume
        Folder of an interrupted or held run to resume.
    first
        Number of the object at the belt end as given by an operator; the belt of a new run is homed to it.
    called
        Called with every call of a device, after it has been recorded.

    Raises
    ------
    CellFileError
        If back-ends, options or files do not fit the cell.
    BeltsortError
        If a file cannot be read.
    """
    broken_off = None if resume is None else progress_in(resume / JOURNAL)
    model, description = known_model(description, None if broken_off is None else broken_off.model)
    calls = RunCalls(runs, resume, called)
    devices: list[object] = []
    cell = compose(description, live=live, say=say, record=calls, made=devices.append)
    folder = calls.folder(dry_run=bool(cell.dry_run))
    if broken_off is not None:
        restore(devices, broken_off)
    model, classifier = model_and_classifier(description, model, progress)
    policy, name = policy_of(description, model, resume)
    return CellRun(
        description,
        cell,
        model,
        classifier,
        policy,
        name,
        folder,
        broken_off,
        first,
        devices,
    )


def restore(devices: Sequence[object], where: Progress) -> None:
    """Restore the state of devices that exist only in this process, such as a simulated cell."""
    for device in devices:
        if isinstance(device, Restorable):
            device.restore(
                where.index,
                first=where.first,
                looks=where.scans,
                taken=where.taken,
                clock=where.stopped,
            )


def first_object(cell: ComposedCell, devices: Sequence[object], given: int | None) -> int:
    """Return the number of the object at the belt end of a new run.

    Parameters
    ----------
    cell
        The cell, whose belt is asked for its position.
    devices
        The devices without wrappers; the belt among them is homed to `given`, unless it is in a dry run.
    given
        Number given by an operator; None if there is none.

    Raises
    ------
    HeldError
        If the belt does not know its position, and `given` is None.
    """
    position = cell.belt.position() if isinstance(cell.belt, TellsPosition) else None
    needs_home = cell.belt.health().needs_home
    if given is None and (needs_home or position == NOWHERE):
        reason = "the belt does not know which object is at the belt end; look"
        raise HeldError(Hold(None, reason, (Way("whichever it is", home=NUMBER),), person=True))
    if given is not None and position is not None and (needs_home or position != given):
        home(devices, given)
    return given if given is not None else position or 0


def home(devices: Sequence[object], index: int) -> None:
    """Home the belt to object `index`, which an operator has seen at the belt end.

    Raises
    ------
    CellError
        If there is no belt that can be homed, or homing is rejected.
    """
    belts = [device for device in devices if isinstance(device, Homing)]
    if not belts:
        raise CellError(
            f"the belt cannot be homed to object {index}, expected a back-end with home(): bring the belt to "
            "this object with its own controls"
        )
    for belt in belts:
        belt.home(index)


def check_ready(cell: ComposedCell | ComposedMovingCell) -> None:
    """Check that every device is ready.

    Raises
    ------
    CommandError
        If devices are not ready, with the reasons; `EmergencyStopError` if the emergency stop is pressed.
    """
    found = CellCheck()
    ask_health(cell, found)
    if found.exceeded:
        pressed = any(health.emergency_stop for health in found.health.values())
        raise (EmergencyStopError if pressed else CommandError)(
            f"{'; '.join(found.exceeded)}; expected every device ready: see `beltsort check` for details",
            Outcome.NOT_DONE,
        )


def true_class_of(devices: Sequence[object]) -> Callable[[int], int | None] | None:
    """Return what tells the true class of an object by its number; None if no device knows classes."""
    return next((device.true_class for device in devices if isinstance(device, KnowsClasses)), None)
