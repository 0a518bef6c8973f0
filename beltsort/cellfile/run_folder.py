"""The folder of a run with a cell file, and the record of its calls."""

from collections.abc import Callable
from pathlib import Path

from beltsort.cell.wrappers.recorder import Recorded
from beltsort.cellfile.description import CellDescription
from beltsort.errors import CellError
from beltsort.sorting.call_log import CallLog
from beltsort.sorting.retention import prune_quietly
from beltsort.sorting.runs import CELL, DRY_RUN, POLICY, run_name


class RunCalls:
    """The folder of a run, new or resumed, and the record of its device calls.

    Parameters
    ----------
    runs
        Folder of all runs.
    resume
        Folder of the run that is resumed; None for a new one.
    called
        Called with every call of a device, after it has been recorded.
    """

    def __init__(self, runs: Path, resume: Path | None, called: Callable[[Recorded], None]) -> None:
        self._resumed, self._called = resume is not None, called
        self._log = CallLog(runs / run_name() if resume is None else resume)

    def __call__(self, recorded: Recorded) -> None:
        """Record a call."""
        self._log(recorded)
        self._called(recorded)

    def folder(self, *, dry_run: bool) -> Path:
        """Return the folder of the run; the name of a dry run's ends in `DRY_RUN`.

        Raises
        ------
        CellError
            If a dry run is resumed as a live one, or the other way round.
        """
        folder = self._log.folder
        if self._resumed:
            was_dry = folder.name.endswith(DRY_RUN)
            if dry_run != was_dry:
                kind, remedy = ("a dry run", "without") if was_dry else ("a live run", "with")
                raise CellError(
                    f"{folder} is {kind}, expected to be resumed as it began: resume it {remedy} --live"
                )
        elif dry_run:
            self._log.folder = folder.with_name(f"{folder.name}{DRY_RUN}")
        return self._log.folder


def write_about(folder: Path, description: CellDescription, policy: str) -> None:
    """Write the names of policy and cell file into the folder of a new run."""
    (folder / POLICY).write_text(f"{policy}\n", "utf-8")
    (folder / CELL).write_text(f"{description.file.resolve()}\n", "utf-8")


def prune_for(folder: Path, description: CellDescription) -> None:
    """Remove old runs when a new one starts, if the cell file limits their number."""
    if description.keep_runs is not None:
        prune_quietly(folder.parent, keep=description.keep_runs, cell=description.file)
