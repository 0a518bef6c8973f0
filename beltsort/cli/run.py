"""`beltsort run`: sort with the cell of a cell file."""

import shlex
import sys
from argparse import Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from beltsort import ArgumentError, BeltsortError
from beltsort.cell.commands import SortInto
from beltsort.cli.arguments import Subparsers, add_cell, add_json, add_rrd
from beltsort.cli.exit_codes import NEEDS_PERSON, TRY_AGAIN
from beltsort.cli.monitoring import Monitoring, add_monitoring, monitoring, monitoring_words
from beltsort.cli.output import print_cell_mode, print_json, print_recording, print_status
from beltsort.cli.progress import stage_progress
from beltsort.planning.named_policy import HELP, located_policy
from beltsort.sorting.holds import Answer, HeldError, Hold
from beltsort.sorting.interrupts import Interrupts
from beltsort.sorting.journal_files import JOURNAL

if TYPE_CHECKING:
    from rich.console import Console

    from beltsort.cellfile.description import CellDescription
    from beltsort.cellfile.run import CellRun
    from beltsort.sorting.progress import Progress
    from beltsort.sorting.report import SortingReport

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
        type=int,
        metavar="N",
        help="number of objects, empty cups included (default: that of the cell file)",
    )
    parser.add_argument(
        "--policy",
        metavar="POLICY",
        help=f"chooses the actions, in place of [planner] in the cell file: {HELP}",
    )
    parser.add_argument(
        "--resume", type=Path, metavar="RUN", help="folder of an interrupted or held run to resume"
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
        help="let `beltsort watch RUN --control` hold the run between two steps, and continue it",
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
    from beltsort.cli.console import RunConsole, discard
    from beltsort.cli.live import run_display
    from beltsort.perception.checks import counted_warnings
    from beltsort.rrd import Recorder
    from beltsort.rrd.package import load_rerun
    from beltsort.sorting.runs import make_folder

    console = RunConsole(stderr=arguments.json)
    if arguments.rrd is not None:
        load_rerun()
    description = load_description(arguments)
    runs = make_folder(Path("runs"))
    with stage_progress(console) as stage:
        opened = open_run(
            description,
            runs,
            live=arguments.live,
            say=console.print,
            progress=stage,
            resume=arguments.resume,
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
    operator = CommandLineOperator(arguments.settle, opened.broken_off)
    with Interrupts() as interrupts, run_display(console) as listener:
        try:
            with counted_warnings():
                report = opened.sort(
                    *((*watching.listeners, listener), operator, interrupts.check),
                    allow_hold=arguments.allow_hold,
                    recorder=recorder,
                )
        except HeldError as held:
            print_status(f"beltsort: {held}")
            for line in ways_to_resume(held.hold, arguments, opened):
                print_status(f"    {line}")
            return NEEDS_PERSON if held.hold.person else TRY_AGAIN
        except (BeltsortError, KeyboardInterrupt):
            if (opened.folder / JOURNAL).exists():
                print_status(f"beltsort: to resume: {shlex.join(resume_command(arguments, opened))}")
            raise
    print_result(console, opened, report)
    print_recording(arguments.rrd)
    if arguments.json:
        try:
            print_json(as_json(opened, report))
            sys.stdout.flush()
        except BrokenPipeError:
            discard(sys.stdout)
    return 0


class CommandLineOperator:
    """Answers the questions of a held run: the first one with `--settle`, others at the terminal.

    Parameters
    ----------
    settle
        The option's value.
    broken_off
        Progress of the run that is resumed; None for a new run.

    Raises
    ------
    ArgumentError
        If the run has no question with this answer.
    """

    def __init__(self, settle: str | None, broken_off: "Progress | None") -> None:
        self._answer = None if settle is None else Answer(settle)
        self._index = None if broken_off is None else broken_off.index
        if self._answer is not None and (broken_off is None or not may_answer(self._answer, broken_off)):
            raise ArgumentError(
                f"--settle is {settle}, but the run waits for no such answer (it may have been given "
                "already): leave it out"
            )

    def __call__(self, hold: Hold) -> Answer | None:
        """Return the answer to a hold, or raise `HeldError` if there is none."""
        answer, self._answer = self._answer, None
        if answer in hold.answers and hold.object == self._index:
            return answer
        # `beltsort home` drives the belt itself, so this run must end and release it first.
        homing = any(way.home is not None for way in hold.ways)
        if homing or sys.stdin is None or not (sys.stdin.isatty() and sys.stderr.isatty()):
            raise HeldError(hold)
        return ask(hold)


def may_answer(answer: Answer, broken_off: "Progress") -> bool:
    """Return whether the first question of a resumed run can have this answer."""
    if answer is Answer.PASSED:
        return True
    pending = broken_off.pending
    sorting = pending is not None and isinstance(pending.act, SortInto)
    return sorting and broken_off.known_outcome is None


def ask(hold: Hold) -> Answer | None:
    """Ask at the terminal which of the hold's ways applies."""
    where = "" if hold.command is None else f" at {hold.command.act}"
    print_status(f"held{where}: {hold.reason}.")
    ways = {"again" if way.answer is None else way.answer.value: way for way in hold.ways}
    for word, way in ways.items():
        print_status(f"    {word}: {way.when}")
    while True:
        print_status(f"Enter {' or '.join(ways)}, or nothing to end the run: ")
        word = sys.stdin.readline().strip().lower()
        if not word:
            raise HeldError(hold)
        if word in ways:
            return ways[word].answer


def ways_to_resume(hold: Hold, arguments: Namespace, opened: "CellRun") -> list[str]:
    """Return a line for each way to resume a held run (or to start it): its condition and its commands."""
    lines = []
    for way in hold.ways:
        settle = [] if way.answer is None else ["--settle", way.answer.value]
        command = shlex.join([*resume_command(arguments, opened), *settle])
        if way.home is not None and opened.homable:
            homing = ["beltsort", "home", arguments.cell, str(way.home), "--live"]
            command = f"{shlex.join(homing)} && {command}"
        elif way.home is not None:
            command = f"bring the belt to object {way.home} with its own controls, then {command}"
        lines.append(f"{way.when}: {command}")
    return lines


def resume_command(arguments: Namespace, opened: "CellRun") -> list[str]:
    """Return the command line that resumes the run, or starts it if it has no journal yet."""
    words = ["beltsort", "run", arguments.cell, *(["--live"] if arguments.live else [])]
    words += ["--allow-hold"] if arguments.allow_hold else []
    words += monitoring_words(arguments)
    if arguments.objects is not None:
        words += ["--objects", str(arguments.objects)]
    if arguments.policy is not None:
        words += ["--policy", arguments.policy]
    if (opened.folder / JOURNAL).exists():
        words += ["--resume", str(opened.folder)]
    return words


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
    if arguments.objects is not None and arguments.objects < 1:
        raise ArgumentError(f"--objects is {arguments.objects}, expected at least 1; give a positive number")
    if arguments.objects is not None:
        changes["objects"] = arguments.objects
    return description.model_copy(update=changes)


def print_result(console: "Console", opened: "CellRun", report: "SortingReport") -> None:
    """Print the number of objects in each bin, how many are right if that is known, and the run's folder."""
    from beltsort.cellfile.results import confusion_of
    from beltsort.planning.bins import sorting_statistics

    sorted_into = [f"{count} {name}" for name, count in report.counts(opened.model.bins).items()]
    empty = [f"{len(report.skipped)} empty"] if report.skipped else []
    passed = [f"{len(report.passed)} PASSED UNSORTED {list(report.passed)}"] if report.passed else []
    parts = [*sorted_into, *empty, *passed]
    console.print(f"{len(report.decisions)} sorted in {report.steps} steps: {', '.join(parts)}")
    counts = confusion_of(opened, report)
    if counts is not None:
        found = sorting_statistics(opened.model, counts)
        console.print(f"{found.right.value:.0f} right; objects by bin and true class:\n{found}")
    if report.drift:
        console.print(f"{len(report.drift)} drift alarms: estimate the tables again before the next run")
    for fault, scans in report.pose_faults.items():
        console.print(f"{scans} scans do not show the belt where their pose says; likely: {fault}")
    console.print(f"journal, model and calls: {opened.folder}")
