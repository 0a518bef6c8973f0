"""Results of a run with the cell of a cell file."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from beltsort import SortingModel
from beltsort.cellfile.moving_run import MovingRun
from beltsort.cellfile.run import CellRun, true_class_of
from beltsort.planning.bins import SortingStatistics, sorting_statistics
from beltsort.sorting.moving.report import MovingReport
from beltsort.sorting.report import SortingReport
from beltsort.sorting.runs import plain_decision
from beltsort.util.text import number_or_none


def as_json(run: CellRun, report: SortingReport) -> dict[str, Any]:
    """Return the results of a run as plain data.

    How many were right, `confusion`, `purity` and `recovery` are there only where the true classes are known.
    """
    counts = confusion_of(run, report)
    return {
        "steps": report.steps,
        "decisions": [plain_decision(decision, run.model.bins) for decision in report.decisions],
        "bins": report.counts.by_bin(run.model.bins),
        **({} if counts is None else _sorted(run.model, counts)),
        "skipped": list(report.skipped),
        "passed": list(report.passed),
        "drift": [alarm.to_dict() for alarm in report.drift],
        "pose_faults": dict(report.pose_faults),
        "dry_run": list(run.cell.dry_run),
        "stopped_by": report.stopped_by,
        "folder": str(run.folder),
    }


def moving_as_json(run: MovingRun, report: MovingReport) -> dict[str, Any]:
    """Return the results of a run on a belt that never stops as plain data; see `as_json`."""
    model = run.belt.model
    known = _sorted(model, confusion_of_moving(report)) if run.knows_classes else {}
    return {
        "objects": report.objects,
        "fates": {str(fate): number for fate, number in report.fates.items()},
        "bins": dict(zip(model.bins, report.bins, strict=True)),
        **known,
        "uncounted": report.uncounted,
        "scans": report.scans,
        "dry_run": list(run.cell.dry_run),
        "stopped_by": report.stopped_by,
        "folder": str(run.folder),
    }


def statistics_of(run: MovingRun, report: MovingReport) -> SortingStatistics | None:
    """Return how well the objects in bins were sorted; None if no device knows classes."""
    if not run.knows_classes:
        return None
    return sorting_statistics(run.belt.model, confusion_of_moving(report))


def confusion_of_moving(report: MovingReport) -> NDArray[np.uint64]:
    """Return the number of objects by bin and true class, shape (B, L)."""
    return np.array(report.confusion, dtype=np.uint64)


def confusion_of(run: CellRun, report: SortingReport) -> NDArray[np.uint64] | None:
    """Return the number of objects by bin and true class, shape (B, L); None if no device knows classes."""
    if true_class_of(run.devices) is None:
        return None
    counted = report.counts.confusion
    shape = len(run.model.bins), len(run.model.classes)
    return np.zeros(shape, dtype=np.uint64) if counted is None else np.array(counted, dtype=np.uint64)


def _sorted(model: SortingModel, counts: NDArray[np.uint64]) -> dict[str, Any]:
    found = sorting_statistics(model, counts)
    return {
        "correct": round(found.right.value),
        "confusion": counts.tolist(),
        "purity": {each.name: number_or_none(each.purity.value) for each in found.bins},
        "recovery": {each.name: number_or_none(each.recovery.value) for each in found.bins},
    }
