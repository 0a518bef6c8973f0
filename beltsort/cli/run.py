"""`beltsort run`: sort with the cell that a file describes."""

import shlex
import sys
from argparse import Namespace
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING

from beltsort import ArgumentError
from beltsort.cli.arguments import Subparsers, add_json
from beltsort.cli.cells import add_cell, tell_pretence
from beltsort.cli.exit_codes import NEEDS_PERSON, TRY_AGAIN
from beltsort.cli.output import print_json, tell
from beltsort.cli.watching import listening, stages
from beltsort.commander import Answer, HeldError, Hold, Operator
from beltsort.interrupts import Interrupts
from beltsort.runs import JOURNAL

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
        choices=[answer.value for answer in Answer],
        help="what you found where the run is held, as it asked",
    )
    parser.add_argument(
        "--first-object",
        type=int,
        metavar="N",
        help="number of the object at the belt end, for a belt that does not know (default: it is asked)",
    )
    add_json(parser)
    parser.set_defaults(run=run)


def run(arguments: Namespace) -> int:
    """Run the command."""
    from beltsort.cell_run import as_json, open_run
    from beltsort.cli.console import LastingConsole, discard_output
    from beltsort.runs import make_folder

    console = LastingConsole(stderr=arguments.json, highlight=False, soft_wrap=True)
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
            first=arguments.first_object,
        )
    tell_pretence(console, description, opened.cell)
    with Interrupts() as interrupts, listening(console) as listener:
        try:
            report = opened.sort(listener, operator(arguments.settle), interrupts.check)
        except HeldError as held:
            tell(f"beltsort: {held}")
            for line in lines_to_type(held.hold, arguments, opened.folder):
                tell(f"    {line}")
            return NEEDS_PERSON if held.hold.person else TRY_AGAIN
    tell_result(console, opened, report)
    if arguments.json:
        try:
            print_json(as_json(opened, report))
            sys.stdout.flush()
        except BrokenPipeError:
            discard_output()
    return 0


def operator(settle: str | None) -> Operator:
    """Return who says what became of a command: the option once, then whoever sits at the terminal."""
    told = [] if settle is None else [Answer(settle)]

    def answer(hold: Hold) -> Answer | None:
        if told and told[0] in hold.answers:
            return told.pop()
        homing = any(way.home is not None for way in hold.ways)  # by another command, which needs the device
        if homing or not (sys.stdin.isatty() and sys.stderr.isatty()):
            raise HeldError(hold)
        return ask(hold)

    return answer


def ask(hold: Hold) -> Answer | None:
    """Ask at the terminal which of the ways is gone."""
    where = "" if hold.command is None else f" at {hold.command.name} {hold.command.target}"
    tell(f"held{where}: {hold.reason}.")
    ways = {"again" if way.answer is None else way.answer.value: way for way in hold.ways}
    for word, way in ways.items():
        tell(f"    {word}: {way.when}")
    while True:
        tell(f"Type {' or '.join(ways)}, or nothing to end the run: ")
        word = sys.stdin.readline().strip().lower()
        if not word:
            raise HeldError(hold)
        if word in ways:
            return ways[word].answer


def lines_to_type(hold: Hold, arguments: Namespace, run: Path) -> list[str]:
    """Return the command lines for each way to go on with a run that is held, or to begin it."""
    live = ["--live"] if arguments.live else []
    begun = ["--resume", str(run)] if (run / JOURNAL).exists() else []
    lines = []
    for way in hold.ways:
        words = ["beltsort", "run", arguments.cell, *live, *begun]
        if way.answer is not None:
            words += ["--settle", way.answer.value]
        homing = ["beltsort", "home", arguments.cell, str(way.home), *live]
        typed = [shlex.join(words)] if way.home is None else [shlex.join(homing), shlex.join(words)]
        lines.append(f"{way.when}: {' && '.join(typed)}")
    return lines


def described(arguments: Namespace) -> "CellDescription":
    """Read the cell file, with the number of objects that was asked for."""
    from beltsort.cell.description import CellDescription

    description = CellDescription.load(arguments.cell)
    first = arguments.first_object
    if first is not None and first < 0:
        raise ArgumentError(f"--first-object is {first}, expected a number from 0 on")
    if first is not None and arguments.resume is not None:
        raise ArgumentError("--first-object is for a new run; a resumed run knows its objects: leave one out")
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
    empty = [f"{len(report.skipped)} empty"] if report.skipped else []
    passed = [f"{len(report.passed)} PASSED UNSORTED {list(report.passed)}"] if report.passed else []
    parts = [*sorted_into, *empty, *passed]
    console.print(f"{len(report.decisions)} sorted in {report.steps} steps: {', '.join(parts)}")
    if report.drift:
        console.print(f"{len(report.drift)} drift alarms: estimate the tables anew before the next run")
    console.print(f"journal, model and calls: {opened.folder}")
