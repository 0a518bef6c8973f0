"""`beltsort run`: sort with the cell that a file describes."""

import sys
from argparse import Namespace
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING

from beltsort import ArgumentError
from beltsort.cell import Outcome
from beltsort.cli.arguments import Subparsers, add_json
from beltsort.cli.cells import add_cell, tell_pretence
from beltsort.cli.output import print_json, tell
from beltsort.cli.watching import listening, stages
from beltsort.command import Command
from beltsort.commander import HeldError, Operator

if TYPE_CHECKING:
    from rich.console import Console

    from beltsort.cell.description import CellDescription
    from beltsort.cell_run import CellRun
    from beltsort.report import SortingReport


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "run",
        help="sort with the cell of a cell file",
        description="Sort the next objects of the belt. Journal, model and a record of every call of a "
        "device are kept in a folder of the run under runs/.",
    )
    add_cell(parser)
    parser.add_argument(
        "--objects", type=int, metavar="N", help="belt places to work through (default: the cell file's)"
    )
    parser.add_argument(
        "--resume", type=Path, metavar="RUN", help="go on with a run that was broken off: its folder"
    )
    parser.add_argument(
        "--settle",
        choices=[Outcome.DONE.value.replace(" ", "-"), Outcome.NOT_DONE.value.replace(" ", "-")],
        help="what became of the command at which the run is held",
    )
    add_json(parser)
    parser.set_defaults(run=run)


def run(arguments: Namespace) -> int:
    """Run the command."""
    from rich.console import Console

    from beltsort.cell_run import as_json, open_run
    from beltsort.runs import make_folder

    console = Console(stderr=arguments.json, highlight=False, soft_wrap=True)
    description = described(arguments)
    runs = make_folder(Path("runs"))
    with stages(console) as stage:
        opened = open_run(
            description,
            runs,
            live=arguments.live,
            say=lambda line: console.print(line, markup=False),
            progress=stage,
            resume=arguments.resume,
        )
    tell_pretence(console, description, opened.cell)
    with listening(console) as listener:
        report = opened.sort(listener, operator(arguments.settle))
    tell_result(console, opened, report)
    if arguments.json:
        print_json(as_json(opened, report))
    return 0


def operator(settle: str | None) -> Operator:
    """Return who tells what became of a command: the option once, then whoever sits at the terminal."""
    told = [] if settle is None else [Outcome(settle.replace("-", " "))]

    def answer(command: Command, reason: str) -> Outcome:
        if told:
            return told.pop()
        if not (sys.stdin.isatty() and sys.stderr.isatty()):
            raise HeldError(command, reason)
        return ask(command, reason)

    return answer


def ask(command: Command, reason: str) -> Outcome:
    """Ask at the terminal."""
    tell(f"held at {command.name} {command.target} ({command.id}): {reason}")
    while True:
        tell("Look at the cell. Was it done? [yes/no] ")
        answer = sys.stdin.readline().strip().lower()
        if not answer:
            raise HeldError(command, reason)
        if answer in ("y", "yes", "n", "no"):
            return Outcome.DONE if answer.startswith("y") else Outcome.NOT_DONE


def described(arguments: Namespace) -> "CellDescription":
    """Read the cell file, with the number of objects that was asked for."""
    from beltsort.cell.description import CellDescription

    description = CellDescription.load(arguments.cell)
    if arguments.objects is None:
        return description
    if arguments.objects < 1:
        raise ArgumentError(f"--objects is {arguments.objects}, expected at least 1; give a positive number")
    return description.model_copy(update={"objects": arguments.objects})


def tell_result(console: "Console", opened: "CellRun", report: "SortingReport") -> None:
    """Say what was sorted, and where the record is."""
    names = [*opened.model.classes, "rejected"]
    counts = Counter(names[-1 if d.label is None else d.label] for d in report.decisions)
    sorted_into = [f"{counts[name]} {name}" for name in names if counts[name]]
    parts = [*sorted_into, f"{len(report.skipped)} empty"] if report.skipped else sorted_into
    console.print(f"{len(report.decisions)} sorted in {report.steps} steps: {', '.join(parts)}")
    if report.drift:
        console.print(f"{len(report.drift)} drift alarms: estimate the tables anew before the next run")
    console.print(f"journal, model and calls: {opened.folder}")
