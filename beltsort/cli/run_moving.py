"""`beltsort run` with a belt that never stops."""

import shlex
from argparse import Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from beltsort import ArgumentError
from beltsort.cli.console import RunConsole, print_last_json
from beltsort.cli.live import run_lines
from beltsort.cli.monitoring import Monitoring
from beltsort.cli.output import print_cell_mode
from beltsort.cli.progress import stage_progress
from beltsort.cli.resuming import print_resuming, report_or_code
from beltsort.cli.signs_of_life import SignsOfLife
from beltsort.sorting.interrupts import Interrupts
from beltsort.sorting.moving.entries import Fate
from beltsort.sorting.moving.report import MovingReport
from beltsort.sorting.runs import RUNS
from beltsort.util.notify import ServiceManager

if TYPE_CHECKING:
    from beltsort.cellfile.description import CellDescription
    from beltsort.cellfile.moving_run import MovingRun


def sort_on_moving_belt(
    arguments: Namespace,
    description: "CellDescription",
    watching: Monitoring,
    manager: ServiceManager,
    resume: Path | None,
) -> int:
    """Sort, print the result and return the exit code.

    Raises
    ------
    ArgumentError
        If an option is given that is for belts that stop.
    """
    from beltsort.cellfile.moving_run import open_moving_run
    from beltsort.cellfile.results import moving_as_json
    from beltsort.perception.checks import counted_warnings

    check_options(arguments)
    console = RunConsole(stderr=arguments.json)
    with stage_progress(console) as stage:
        opened = open_moving_run(
            description,
            RUNS,
            live=arguments.live,
            say=console.print,
            progress=stage,
            resume=resume,
            called=watching.called,
        )
    watching.opened(opened)
    print_cell_mode(console, description, opened.cell)
    if arguments.allow_hold:
        command = shlex.join(["beltsort", "stop", str(opened.folder)])
        console.print(f"to stop the belt and end the run: {command}")
    interrupts = Interrupts()
    signs = SignsOfLife(manager, interrupts.check)
    listeners = (*watching.listeners, signs.listen, run_lines(console))
    with interrupts:
        try:
            with counted_warnings():
                report = report_or_code(
                    lambda: opened.sort(listeners, signs.check, allow_hold=arguments.allow_hold),
                    arguments,
                    opened.folder,
                    homable=False,
                )
        finally:
            manager.tell("STOPPING=1")
    if isinstance(report, int):
        return report
    print_result(console, opened, report)
    if report.stopped_by is not None:
        print_resuming(arguments, opened.folder)
    if arguments.json:
        print_last_json(moving_as_json(opened, report))
    return 0


def check_options(arguments: Namespace) -> None:
    """Refuse options that are for belts that stop.

    Raises
    ------
    ArgumentError
        If one is given.
    """
    for option, what in (
        ("rrd", "the recording of a run"),
        ("first_object", "the number of the object at the belt end"),
        ("settle", "an answer to a question about a command"),
    ):
        value = getattr(arguments, option)
        if value is not None:
            raise ArgumentError(
                f"--{option.replace('_', '-')} is {value}, {what}, which a cell file with [moving] does not "
                "support: leave it out"
            )


def print_result(console: RunConsole, opened: "MovingRun", report: MovingReport) -> None:
    """Print what became of the objects, how many are right if that is known, and the run's folder."""
    from beltsort.cellfile.results import statistics_of

    if report.stopped_by is not None:
        console.print(f"stopped: {report.stopped_by} asked to; the belt stands")
    console.print(f"{report.objects} objects in {report.scans} scans: {in_words(report, opened)}")
    found = statistics_of(opened, report)
    if found is not None:
        console.print(f"{found.right.value:.0f} right; objects by bin and true class:\n{found}")
    console.print(f"journal, model and calls: {opened.folder}")


def in_words(report: MovingReport, opened: "MovingRun") -> str:
    """Return the number of objects in each bin, and of those that have left in another way."""
    bins = zip(opened.belt.model.bins, report.bins, strict=True)
    parts = [f"{count} {name}" for name, count in bins if count]
    parts += [f"{n} {fate}" for fate, n in report.fates.items() if n and fate is not Fate.IN_BIN]
    parts += [f"up to {report.uncounted} passed uncounted"] if report.uncounted else []
    return ", ".join(parts) or "none"
