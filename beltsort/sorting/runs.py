"""A run: its folder, and what is kept of it."""

import json
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from beltsort import SortingModel
from beltsort.cell.protocols import Cell
from beltsort.errors import JournalError
from beltsort.planning.policy import Policy
from beltsort.sorting.holds import Operator, nobody
from beltsort.sorting.journal import Journal, Listeners
from beltsort.sorting.journal_files import JOURNAL
from beltsort.sorting.kept_scans import ScanKeeper, ScanListener, all_of
from beltsort.sorting.loop import Check, nothing, sort_objects
from beltsort.sorting.perceived import Perceive
from beltsort.sorting.report import Decision, SortingReport
from beltsort.sorting.rules import Drift, Rules

MODEL, LOCK = "model.json", "lock"
TRUTH = "true-classes.json"
POLICY = "policy.txt"
"""The name of the policy, in the folder of a run with a cell file."""


def make_folder(folder: Path) -> Path:
    """Make a folder for runs, or for one run, and return it.

    Raises
    ------
    JournalError
        If it cannot be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as reason:
        raise JournalError(
            f"the run folder {folder} cannot be made: {reason}; work in a folder that can be written"
        ) from reason
    return folder


def run_name() -> str:
    """Return a name for a run of now."""
    return datetime.now(UTC).strftime("%Y-%m-%dT%H-%M-%S.%fZ")


def sort_into(
    folder: Path,
    cell: Cell,
    perceive: Perceive,
    policy: Policy,
    model: SortingModel,
    *,
    objects: int,
    first: int = 0,
    belt_ends: bool = False,
    rules: Rules | None = None,
    operator: Operator = nobody,
    drift: Drift | None = None,
    listener: Listeners = None,
    check: Check = nothing,
    requests: Path | None = None,
    scan_listener: ScanListener | None = None,
) -> SortingReport:
    """Sort the next objects of the belt; model, journal and latest scans are kept in an existing folder.

    Parameters, returns and raises as `beltsort.sorting.loop.sort_objects`; `listener` (there may
    be several) is called with every entry of the journal.
    """
    rules = rules or Rules()
    model.save(folder / MODEL)
    with Journal(folder / JOURNAL, listener) as journal:
        return sort_objects(
            *(cell, perceive, policy, model, journal),
            objects=objects,
            first=first,
            belt_ends=belt_ends,
            rules=rules,
            operator=operator,
            drift=drift,
            check=check,
            requests=requests,
            scan_listener=all_of(ScanKeeper(folder, cell, rules.kept_scans), scan_listener),
        )


def write_true_classes(folder: Path, first: int, true: Sequence[int | None]) -> None:
    """Keep the true classes of a simulated run's objects in its folder, for those who look at it afterwards.

    Parameters
    ----------
    folder
        The run's.
    first
        Number of the first object.
    true
        Class index of each object from there on; None for an empty cup.
    """
    classes = {str(first + n): label for n, label in enumerate(true)}
    (folder / TRUTH).write_text(json.dumps(classes) + "\n")


def read_true_classes(folder: Path) -> dict[int, int | None]:
    """Return the class index of each object by its number, None for an empty cup; nothing if not known."""
    try:
        classes = json.loads((folder / TRUTH).read_text("utf-8"))
        return {int(number): None if label is None else int(label) for number, label in classes.items()}
    except (OSError, ValueError, TypeError, AttributeError):
        return {}


def plain_decision(decision: Decision, bins: Sequence[str]) -> dict[str, Any]:
    """Return a decision as plain data, with the name of its bin out of the model's `bins`."""
    return {
        "object": decision.object,
        "decided": None if decision.label is None else bins[decision.label],
        "looks": decision.looks,
        "belief": decision.belief,
        "forced": decision.forced,
    }
