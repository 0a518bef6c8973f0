"""`beltsort run`: sort with the cell of a cell file."""

import shlex
from argparse import ArgumentTypeError, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from beltsort import ArgumentError
from beltsort.cli.arguments import Subparsers, add_cell, add_json, add_rrd
from beltsort.cli.monitoring import Monitoring, add_monitoring, monitoring
from beltsort.cli.operator import CommandLineOperator
from beltsort.cli.output import print_cell_mode, print_recording, print_status
from beltsort.cli.progress import stage_progress
from beltsort.cli.resuming import print_resuming, report_or_code, run_to_resume
from beltsort.cli.ros2 import ros2_node
from beltsort.cli.signs_of_life import SignsOfLife, check_watchdog
from beltsort.planning.named_policy import HELP, located_policy
from beltsort.sorting.holds import Answer
from beltsort.sorting.interrupts import Interrupts
from beltsort.sorting.runs import RUNS, make_folder
from beltsort.util.notify import ServiceManager

if TYPE_CHECKING:
    from rich.console import Console

    from beltsort.cellfile.description import CellDescription
    from beltsort.cellfile.run import CellRun
    from beltsort.sorting.report import SortingReport

UNLIMITED = "unlimited"

EXAMPLE = "beltsort run cell.toml --objects 5"


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "run",
        help="sort with the cell of a cell file",
        description="Sort the next objects on the belt. The journal, the model and a log of all calls of "
        "devices are written to a folder of the run under runs/. docs/recovery.md describes how a run that "
        "was interrupted or is held continues.",
    )
    add_cell(parser)
    parser.add_argument(
        "--objects",
        type=number_of_objects,
        metavar="N",
        help="number of objects, empty cups included, or `unlimited`: until the run is told to stop "
        "(default: that of the cell file)",
    )
    parser.add_argument(
        "--policy",
        metavar="POLICY",
        help=f"chooses the actions, in place of [planner] in the cell file: {HELP}",
    )
    resuming = parser.add_mutually_exclusive_group()
    resuming.add_argument(
        "--resume",
        type=Path,
        metavar="RUN",
        help="folder of an interrupted or held run to resume, or `latest` for the newest run of this cell in "
        "runs/, which must not be finished",
    )
    resuming.add_argument(
        "--service",
        action="store_true",
        help="resume the newest run of this cell in runs/, or start a new run if it is finished or there is "
        "none: for a service manager (docs/service.md)",
    )
    parser.add_argument(
        "--settle",
        choices=[answer.value for answer in Answer],
        help="answer to the question of a held run that is resumed",
    )
    parser.add_argument(
        "--first-object",
        type=int,
        metavar="N",
        help="number of the object at the belt end; homes the belt if its position is not known (default: "
        "the number that the belt reports)",
    )
    parser.add_argument(
        "--allow-hold",
        action="store_true",
        help="let `beltsort hold`, `continue`, `stop` and `settle`, and `beltsort watch RUN --control`, act "
        "on the run while it goes on",
    )
    add_rrd(parser)
    add_monitoring(parser)
    add_json(parser)
    parser.set_defaults(run=run)


def run(arguments: Namespace) -> int:
    """Run the command."""
    with monitoring(arguments) as watching:
        return sort(arguments, watching)


def sort(arguments: Namespace, watching: Monitoring) -> int:
    """Sort, print the result and return the exit code."""
    from beltsort.cellfile.results import as_json
    from beltsort.cellfile.run import open_run, true_class_of
    from beltsort.cli.console import RunConsole, print_last_json
    from beltsort.cli.live import run_display
    from beltsort.cli.run_moving import sort_on_moving_belt
    from beltsort.perception.checks import counted_warnings
    from beltsort.rrd import Recorder
    from beltsort.rrd.package import load_rerun

    console = RunConsole(stderr=arguments.json)
    if arguments.rrd is not None:
        load_rerun()
    description = load_description(arguments)
    manager = ServiceManager.of_environment()
    check_watchdog(manager, description)
    runs = make_folder(RUNS)
    resume = run_to_resume(arguments, description)
    if description.moving is not None:
        return sort_on_moving_belt(arguments, description, watching, manager, resume)
    with stage_progress(console) as stage:
        opened = open_run(
            description,
            runs,
            live=arguments.live,
            say=console.print,
            progress=stage,
            resume=resume,
            first=arguments.first_object,
            called=watching.called,
        )
    watching.opened(opened)
    print_cell_mode(console, description, opened.cell)
    if arguments.allow_hold:
        command = shlex.join(["beltsort", "watch", str(opened.folder), "--control"])
        console.print(f"to hold and continue the run: {command}")
    true_class = true_class_of(opened.devices)
    recorder = (
        None
        if arguments.rrd is None
        else Recorder(arguments.rrd, opened.cell, opened.model, print_status, true_class)
    )
    requests = opened.folder if arguments.allow_hold else None
    interrupts = Interrupts()
    signs = SignsOfLife(manager, interrupts.check)
    operator = CommandLineOperator(arguments.settle, opened.broken_off, requests, signs.check)
    with interrupts, ros2_node(opened) as node, run_display(console) as display:
        try:
            with counted_warnings():
                report = report_or_code(
                    lambda: opened.sort(
                        *((*watching.listeners, node, signs.listen, display), operator, signs.check),
                        allow_hold=arguments.allow_hold,
                        recorder=recorder,
                        scan_listener=None if node is None else node.scanned,
                    ),
                    arguments,
                    opened.folder,
                    homable=opened.homable,
                )
        finally:
            manager.tell("STOPPING=1")
    if isinstance(report, int):
        return report
    print_result(console, opened, report)
    if report.stopped_by is not None:
        print_resuming(arguments, opened.folder)
    print_recording(arguments.rrd)
    if arguments.json:
        print_last_json(as_json(opened, report))
    return 0


def load_description(arguments: Namespace) -> "CellDescription":
    """Read the cell file and apply `--objects` and `--policy`."""
    from beltsort.cellfile.description import CellDescription
    from beltsort.cellfile.sections import Planner

    description = CellDescription.load(arguments.cell)
    first = arguments.first_object
    if first is not None and first < 0:
        raise ArgumentError(f"--first-object is {first}, expected at least 0; give the object's number")
    if first is not None and arguments.resume is not None:
        raise ArgumentError(
            f"--first-object {first} is for a new run, and --resume {arguments.resume} continues with the "
            "object of its journal: leave one out"
        )
    changes: dict[str, object] = {}
    if arguments.policy is not None:
        changes["planner"] = Planner(policy=located_policy(arguments.policy, Path().resolve()))
    objects = arguments.objects
    if isinstance(objects, int) and objects < 1:
        raise ArgumentError(f"--objects is {objects}, expected at least 1; give a positive number")
    if objects is not None:
        changes["objects"] = None if objects == UNLIMITED else objects
    if objects == UNLIMITED and description.belt_ends:
        raise ArgumentError("--objects is unlimited, but belt_ends is true; expected a number: give one")
    return description.model_copy(update=changes)


def number_of_objects(text: str) -> int | str:
    """Parse the number of objects."""
    if text == UNLIMITED:
        return text
    try:
        return int(text)
    except ValueError as reason:
        raise ArgumentTypeError(f"{text!r}: expected a number, or `{UNLIMITED}`") from reason


def print_result(console: "Console", opened: "CellRun", report: "SortingReport") -> None:
    """Print the number of objects in each bin, how many are right if that is known, and the run's folder."""
    from beltsort.cellfile.results import confusion_of
    from beltsort.planning.bins import sorting_statistics

    sorted_into = [f"{count} {name}" for name, count in report.counts.by_bin(opened.model.bins).items()]
    empty = [f"{report.counts.skipped} empty"] if report.skipped else []
    passed = [f"{report.counts.passed} PASSED UNSORTED {list(report.passed)}"] if report.passed else []
    parts = [*sorted_into, *empty, *passed]
    if report.stopped_by is not None:
        console.print(f"stopped: {report.stopped_by} asked to")
    console.print(f"{report.counts.sorted} sorted in {report.steps} steps: {', '.join(parts)}")
    counts = confusion_of(opened, report)
    if counts is not None:
        found = sorting_statistics(opened.model, counts)
        console.print(f"{found.right.value:.0f} right; objects by bin and true class:\n{found}")
    if report.drift:
        console.print(f"{len(report.drift)} drift alarms: estimate the tables again before the next run")
    for fault, scans in report.pose_faults.items():
        console.print(f"{scans} scans do not show the belt where their pose says; likely: {fault}")
    console.print(f"journal, model and calls: {opened.folder}")
