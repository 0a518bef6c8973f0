"""How a run that ended early is resumed, and which one is."""

import shlex
from argparse import Namespace
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from beltsort import ArgumentError, BeltsortError
from beltsort.cli.exit_codes import NEEDS_PERSON, TRY_AGAIN
from beltsort.cli.monitoring import monitoring_words
from beltsort.cli.output import print_status
from beltsort.sorting.holds import HeldError, Hold
from beltsort.sorting.journal_files import JOURNAL
from beltsort.sorting.runs import LATEST, RUNS, unfinished_run

if TYPE_CHECKING:
    from beltsort.cellfile.description import CellDescription

Report = TypeVar("Report")


def report_or_code(
    sort: Callable[[], Report], arguments: Namespace, folder: Path, *, homable: bool
) -> Report | int:
    """Return what a run returns, or the exit code of a hold; if it ends early, print how to resume it.

    Parameters
    ----------
    sort
        Runs.
    arguments
        Those of `beltsort run`.
    folder
        The run's.
    homable
        Whether there is a belt that can be homed.
    """
    try:
        return sort()
    except HeldError as held:
        print_status(f"beltsort: {held}")
        for line in ways_to_resume(held.hold, arguments, folder, homable=homable):
            print_status(f"    {line}")
        return NEEDS_PERSON if held.hold.person else TRY_AGAIN
    except (BeltsortError, KeyboardInterrupt):
        if (folder / JOURNAL).exists():
            print_resuming(arguments, folder)
        raise


def print_resuming(arguments: Namespace, folder: Path) -> None:
    """Print the command line that resumes a run."""
    print_status(f"beltsort: to resume: {shlex.join(resume_command(arguments, folder))}")


def ways_to_resume(hold: Hold, arguments: Namespace, folder: Path, *, homable: bool) -> list[str]:
    """Return a line for each way to resume a held run (or to start it): its condition and its commands."""
    lines = []
    for way in hold.ways:
        settle = [] if way.answer is None else ["--settle", way.answer.value]
        command = shlex.join([*resume_command(arguments, folder), *settle])
        if way.home is not None and homable:
            homing = ["beltsort", "home", arguments.cell, str(way.home), "--live"]
            command = f"{shlex.join(homing)} && {command}"
        elif way.home is not None:
            command = f"bring the belt to object {way.home} with its own controls, then {command}"
        lines.append(f"{way.when}: {command}")
    return lines


def resume_command(arguments: Namespace, folder: Path) -> list[str]:
    """Return the command line that resumes the run, or starts it if it has no journal yet."""
    words = ["beltsort", "run", arguments.cell, *(["--live"] if arguments.live else [])]
    words += ["--allow-hold"] if arguments.allow_hold else []
    words += monitoring_words(arguments)
    if arguments.objects is not None:
        words += ["--objects", str(arguments.objects)]
    if arguments.policy is not None:
        words += ["--policy", arguments.policy]
    if (folder / JOURNAL).exists():
        words += ["--resume", str(folder)]
    return words


def run_to_resume(arguments: Namespace, description: "CellDescription") -> Path | None:
    """Return the folder of the run that is to be resumed; None for a new run.

    Raises
    ------
    ArgumentError
        If the newest run is to be resumed and there is none that is not finished.
    """
    from beltsort.cellfile.making import roles_in_dry_run

    given: Path | None = arguments.resume
    if given != LATEST and not arguments.service:
        return given
    dry_run = bool(roles_in_dry_run(description, live=arguments.live))
    folder = unfinished_run(RUNS, Path(arguments.cell), dry_run=dry_run)
    if folder is None and not arguments.service:
        raise ArgumentError(
            f"--resume latest: the newest run of {arguments.cell} in {RUNS}/ is finished, or there is none; "
            "leave --resume out to start another"
        )
    if folder is not None and arguments.first_object is not None:
        raise ArgumentError(
            f"--first-object {arguments.first_object} is for a new run, and {folder} is not finished: leave "
            "it out"
        )
    if folder is not None:
        print_status(f"beltsort: {folder} is resumed")
    return folder
