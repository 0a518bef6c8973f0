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
from beltsort.sorting.heeding import Check, nothing
from beltsort.sorting.holds import Operator, nobody
from beltsort.sorting.journal import Journal, Listeners
from beltsort.sorting.journal_files import JOURNAL
from beltsort.sorting.journal_queries import has_entries
from beltsort.sorting.kept_scans import ScanKeeper, ScanListener, all_of
from beltsort.sorting.loop import sort_objects
from beltsort.sorting.moving.reading import is_moving, moving_state_in
from beltsort.sorting.perceived import Perceive
from beltsort.sorting.record import progress_in
from beltsort.sorting.report import Decision, SortingReport
from beltsort.sorting.rules import Drift, Rules

MODEL, LOCK = "model.json", "lock"
TRUTH = "true-classes.json"
POLICY = "policy.txt"
"""The name of the policy, in the folder of a run with a cell file."""
CELL = "cell.txt"
"""The path of the cell file, in the folder of a run with one."""
DRY_RUN = "-dry-run"
"""Suffix of the folder's name of a dry run."""
REMOVED = ".removed"
"""Suffix of the name of a run's folder while it is being removed."""
RUNS, LATEST = Path("runs"), Path("latest")
"""Folder in which runs are made, and what stands for the newest one in it."""


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


def journals_in(runs: Path) -> list[Path]:
    """Return the journals in a folder of runs, oldest first: folders are named by the time of their start."""
    journals = runs.glob(f"*/{JOURNAL}")
    return sorted(journal for journal in journals if not journal.parent.name.endswith(REMOVED))


def journal_of(run: Path) -> Path:
    """Return the journal of a run.

    Parameters
    ----------
    run
        The run's folder, its journal, a folder of runs for the newest, or `LATEST` for the newest in `RUNS`.
    """
    if run == LATEST:
        run = RUNS
    if not run.is_dir() or (run / JOURNAL).exists():
        return run / JOURNAL if run.is_dir() else run
    journals = journals_in(run)
    return journals[-1] if journals else run / JOURNAL


def folder_of(run: Path) -> Path:
    """Return the folder of a run, which `journal_of` finds.

    Raises
    ------
    JournalError
        If it has no journal.
    """
    journal = journal_of(run)
    if not journal.is_file():
        raise JournalError(f"{run} has no journal; name a run's folder, or start a run")
    return journal.parent


def unfinished_run(runs: Path, cell: Path, *, dry_run: bool) -> Path | None:
    """Return the folder of a cell's newest run if it is not finished; None if it is, or there is none.

    An older run that is not finished is never returned: the belt has moved on since.

    Parameters
    ----------
    runs
        Folder of runs.
    cell
        The cell file. Runs that do not say what cell they are of, of older versions, count as this cell's.
    dry_run
        Whether dry runs are considered, or all others.

    Raises
    ------
    JournalError
        If the newest run's journal is damaged.
    """
    for journal in reversed(journals_in(runs)):
        folder = journal.parent
        if folder.name.endswith(DRY_RUN) is not dry_run or not _is_of(folder, cell):
            continue
        if has_entries(journal):  # without entries nothing was done
            state = moving_state_in(journal) if is_moving(journal) else progress_in(journal)
            return None if state.done else folder
    return None


def cell_file_of(folder: Path) -> Path | None:
    """Return the cell file of a run; None if the run does not say."""
    try:
        return Path((folder / CELL).read_text("utf-8").rstrip("\n"))
    except (OSError, ValueError):
        return None


def _is_of(folder: Path, cell: Path) -> bool:
    own = cell_file_of(folder)
    return own is None or own == cell.resolve()


def sort_into(
    folder: Path,
    cell: Cell,
    perceive: Perceive,
    policy: Policy,
    model: SortingModel,
    *,
    objects: int | None,
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
