"""Sorting with a cell that a file describes."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from beltsort import Despot, SortingModel
from beltsort.cell.check import CellCheck, ask_health
from beltsort.cell.composed import ComposedCell, compose
from beltsort.cell.description import CellDescription
from beltsort.cell.problems import CellFileError
from beltsort.cell.protocols import Homing, Restorable
from beltsort.cell.simulated.backend import trainable_config
from beltsort.commander import Operator, nobody
from beltsort.errors import CellError
from beltsort.journal import Journal, Listener
from beltsort.perception import NearestNeighbour, Perception, PerceptionConfig
from beltsort.progress import Progress
from beltsort.record import progress_in
from beltsort.report import SortingReport
from beltsort.runs import JOURNAL, CallLog, make_folder, plain_decision, run_name, sort_into
from beltsort.sorter import resume_sorting
from beltsort.tables.prepare import Recipe, StageProgress, prepare


@dataclass(frozen=True, eq=False)
class CellRun:
    """A cell that is ready to sort.

    Attributes
    ----------
    description
        What its file says.
    cell
        Its devices.
    model, classifier
        What the file names, or what was prepared.
    folder
        Of the run; made by `sort`.
    broken_off
        How far the run had come that is resumed; None for a new one.
    homing
        Belts that a new run tells that its first object is at the belt end.
    """

    description: CellDescription
    cell: ComposedCell
    model: SortingModel
    classifier: NearestNeighbour
    folder: Path
    broken_off: Progress | None = None
    homing: Sequence[Homing] = ()

    def sort(self, listener: Listener | None = None, operator: Operator = nobody) -> SortingReport:
        """Sort the objects, or those that are left, journalling every step.

        Whatever ends the run early stops all devices; `operator` is as in `beltsort.sorter.sort_objects`.

        Raises
        ------
        CellError
            If a device is not ready.
        BeltsortError
            As `beltsort.sorter.sort_objects`.
        """
        description = self.description
        perception = Perception(description.layout, self.classifier, description.perception)
        planner = Despot(self.model, **description.planner.settings())
        make_folder(self.folder)
        check_ready(self.cell)
        if self.broken_off is not None:
            with Journal(self.folder / JOURNAL, listener, resume=True) as journal:
                return resume_sorting(
                    *(self.cell, perception, planner, journal),
                    rules=description.rules,
                    operator=operator,
                    drift=description.drift,
                )
        for belt in self.homing:
            belt.home(0)
        return sort_into(
            self.folder,
            self.cell,
            perception,
            planner,
            self.model,
            objects=description.objects,
            belt_ends=description.belt_ends,
            rules=description.rules,
            operator=operator,
            drift=description.drift,
            listener=listener,
        )


def open_run(
    description: CellDescription,
    runs: Path,
    *,
    live: bool,
    say: Callable[[str], None],
    progress: StageProgress | None = None,
    resume: Path | None = None,
) -> CellRun:
    """Make the devices, and load model and classifier or prepare them.

    Parameters
    ----------
    description
        The cell file.
    runs
        Folder of all runs.
    live
        Whether things may move; otherwise what can move something real is put into a dry run, and the run's
        folder is named so.
    say
        Called with what a dry run would have done.
    progress
        Called with each stage of `prepare`.
    resume
        Folder of a run that was broken off and is to go on.

    Raises
    ------
    CellFileError
        If back-ends, options or files do not fit the cell.
    BeltsortError
        If a file cannot be read.
    """
    broken_off = None if resume is None else progress_in(resume / JOURNAL)
    calls = CallLog(runs / run_name() if resume is None else resume)

    devices: list[object] = []
    cell = compose(description, live=live, say=say, record=calls, made=devices.append)
    if broken_off is not None:
        _bring_back(devices, broken_off)
    if cell.rehearsed and resume is None:
        calls.folder = runs / f"{calls.folder.name}-dry-run"
    model, classifier = _knowledge(description, progress)
    return CellRun(
        description,
        cell,
        model if broken_off is None else broken_off.model,
        classifier,
        calls.folder,
        broken_off,
        [] if cell.rehearsed else [device for device in devices if isinstance(device, Homing)],
    )


def _bring_back(devices: Sequence[object], where: Progress) -> None:
    """Have the devices whose world ended with the process stand where the run broke off."""
    for device in devices:
        if isinstance(device, Restorable):
            device.restore(where.index, looks=where.glances, taken=where.taken, clock=where.stopped)


def check_ready(cell: ComposedCell) -> None:
    """Refuse a cell with a device that is not ready.

    Raises
    ------
    CellError
        Naming each of them, and why.
    """
    found = CellCheck()
    ask_health(cell, found)
    if found.exceeded:
        raise CellError(
            f"{'; '.join(found.exceeded)}; expected every device ready: `beltsort check` tells more"
        )


def as_json(run: CellRun, report: SortingReport) -> dict[str, Any]:
    """Return a run as plain data."""
    return {
        "steps": report.steps,
        "decisions": [plain_decision(decision, run.model.classes) for decision in report.decisions],
        "skipped": list(report.skipped),
        "drift": [alarm.to_dict() for alarm in report.drift],
        "dry_run": list(run.cell.rehearsed),
        "folder": str(run.folder),
    }


def _knowledge(
    description: CellDescription, progress: StageProgress | None
) -> tuple[SortingModel, NearestNeighbour]:
    """Return model and classifier."""
    if description.prepare is not None:
        perception = description.perception or PerceptionConfig()
        amounts = description.prepare.model_dump()
        prepared = prepare(Recipe(trainable_config(description), perception, **amounts), progress=progress)
        model = prepared.counts.model(description.classes, description.viewpoint_names)
        return model, prepared.database
    model = SortingModel.load(description.path(description.model or ""))
    classifier = NearestNeighbour.load(description.path(description.classifier or ""))
    if classifier.classes != description.classes:
        raise CellFileError.of(
            "classifier",
            f"knows the classes {list(classifier.classes)}, expected {list(description.classes)}, in this "
            "order: train it on these",
        )
    return model, classifier
