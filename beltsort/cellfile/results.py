"""Results of a run with the cell of a cell file."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from beltsort import SortingModel
from beltsort.cellfile.run import CellRun, true_class_of
from beltsort.planning.bins import sorting_statistics
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
