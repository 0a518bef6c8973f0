"""`beltsort run`: sort with the cell that a file describes."""

import shlex
import sys
from argparse import Namespace
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING

from beltsort import ArgumentError, BeltsortError
from beltsort.cell.commands import SortInto
from beltsort.cli.arguments import Subparsers, add_json
from beltsort.cli.cells import add_cell, tell_pretence
from beltsort.cli.exit_codes import NEEDS_PERSON, TRY_AGAIN
from beltsort.cli.output import print_json, tell
from beltsort.cli.watching import listening, stages
from beltsort.sorting.holds import Answer, HeldError, Hold
from beltsort.sorting.interrupts import Interrupts
from beltsort.sorting.runs import JOURNAL

if TYPE_CHECKING:
    from rich.console import Console

    from beltsort.cellfile.description import CellDescription
    from beltsort.cellfile.run import CellRun
    from beltsort.sorting.progress import Progress
    from beltsort.sorting.report import SortingReport


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
    from beltsort.cellfile.run import as_json, open_run
    from beltsort.cli.console import LastingConsole, discard
    from beltsort.sorting.runs import make_folder

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
    operator = Settling(arguments.settle, opened.broken_off)
    with Interrupts() as interrupts, listening(console) as listener:
        try:
            report = opened.sort(listener, operator, interrupts.check)
        except HeldError as held:
            tell(f"beltsort: {held}")
            for line in lines_to_type(held.hold, arguments, opened):
                tell(f"    {line}")
            return NEEDS_PERSON if held.hold.person else TRY_AGAIN
        except (BeltsortError, KeyboardInterrupt):
            if (opened.folder / JOURNAL).exists():
                tell(f"beltsort: to go on: {shlex.join(words_to_resume(arguments, opened))}")
            raise
    tell_result(console, opened, report)
    if arguments.json:
        try:
            print_json(as_json(opened, report))
            sys.stdout.flush()
        except BrokenPipeError:
            discard(sys.stdout)
    return 0


class Settling:
    """Gives the answer of `--settle` where the run asks for it, or asks at the terminal.

    Parameters
    ----------
    settle
        The option.
    broken_off
        How far the run had come that is resumed.

    Raises
    ------
    ArgumentError
        If the run waits for no such answer.
    """

    def __init__(self, settle: str | None, broken_off: "Progress | None") -> None:
        self._answer = None if settle is None else Answer(settle)
        self._index = None if broken_off is None else broken_off.index
        if self._answer is not None and (broken_off is None or not waits_for(self._answer, broken_off)):
            raise ArgumentError(
                f"--settle is {settle}, but this run waits for no such answer (it may have been given "
                "already): leave it out"
            )

    def __call__(self, hold: Hold) -> Answer | None:
        """Return the answer to a hold: the option answers the first question only."""
        answer, self._answer = self._answer, None
        if answer in hold.answers and hold.object == self._index:
            return answer
        homing = any(way.home is not None for way in hold.ways)  # by another command, which needs the device
        if homing or sys.stdin is None or not (sys.stdin.isatty() and sys.stderr.isatty()):
            raise HeldError(hold)
        return ask(hold)


def waits_for(answer: Answer, broken_off: "Progress") -> bool:
    """Tell whether an answer can be about where a run was broken off."""
    if answer is Answer.PASSED:
        return True
    pending = broken_off.pending
    sorting = pending is not None and isinstance(pending.act, SortInto)
    return sorting and broken_off.known_outcome is None


def ask(hold: Hold) -> Answer | None:
    """Ask at the terminal which of the ways is gone."""
    where = "" if hold.command is None else f" at {hold.command.act}"
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


def lines_to_type(hold: Hold, arguments: Namespace, opened: "CellRun") -> list[str]:
    """Return what to type for each way to go on with a run that is held, or to begin it."""
    lines = []
    for way in hold.ways:
        settle = [] if way.answer is None else ["--settle", way.answer.value]
        typed = shlex.join([*words_to_resume(arguments, opened), *settle])
        if way.home is not None and opened.homable:
            homing = ["beltsort", "home", arguments.cell, str(way.home), "--live"]
            typed = f"{shlex.join(homing)} && {typed}"
        elif way.home is not None:
            typed = f"bring the belt to object {way.home} by its own means, then {typed}"
        lines.append(f"{way.when}: {typed}")
    return lines


def words_to_resume(arguments: Namespace, opened: "CellRun") -> list[str]:
    """Return the command that goes on with a run, or begins it if it has not begun."""
    words = ["beltsort", "run", arguments.cell, *(["--live"] if arguments.live else [])]
    if arguments.objects is not None:
        words += ["--objects", str(arguments.objects)]
    if (opened.folder / JOURNAL).exists():
        words += ["--resume", str(opened.folder)]
    return words


def described(arguments: Namespace) -> "CellDescription":
    """Read the cell file, with the number of objects that was asked for."""
    from beltsort.cellfile.description import CellDescription

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
