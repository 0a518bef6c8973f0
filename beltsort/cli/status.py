"""`beltsort status`: print the state of a run."""

import shlex
from argparse import Namespace
from dataclasses import asdict, dataclass
from pathlib import Path

from beltsort.cli.arguments import Subparsers, add_json
from beltsort.cli.output import print_json
from beltsort.cli.show import add_run
from beltsort.sorting.holds import Way
from beltsort.sorting.moving.entries import Fate
from beltsort.sorting.requests import read_token, standing_hold
from beltsort.sorting.runs import DRY_RUN, cell_file_of, folder_of
from beltsort.sorting.status import Condition, RunStatus, status_of

EXAMPLE = "beltsort status latest"


@dataclass(frozen=True)
class NextCommand:
    """What a person can type next.

    Attributes
    ----------
    when
        Under which condition, or to what end.
    command
        The command line.
    """

    when: str
    command: str


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "status",
        help="print the state of a run",
        description="Print whether a run goes on, is held or has ended, what it has done, and what to type "
        "next. Nothing is written.",
    )
    add_run(parser)
    add_json(parser)
    parser.set_defaults(run=run)


def run(arguments: Namespace) -> int:
    """Read and print."""
    status = status_of(folder_of(arguments.folder))
    ways = ways_on(status)
    if arguments.json:
        print_json({**asdict(status), "folder": str(status.folder), "next": [asdict(way) for way in ways]})
        return 0
    print(f"{status.folder}: {status.condition}{'' if status.pid is None else f', process {status.pid}'}")
    if status.reason:
        print(status.reason)
    of = "" if status.objects is None else f", {status.left} of {status.objects} left"
    last = status.updated[:19].replace("T", " ")
    where = "at the belt end" if status.fates is None else "is the first undecided one"
    print(f"object {status.object} {where}{of}; last entry {last} UTC")
    parts = [f"{count} {name}" for name, count in status.bins.items()]
    if status.fates is None:
        parts += [f"{status.skipped} empty"] if status.skipped else []
        parts += [f"{status.passed} PASSED UNSORTED"] if status.passed else []
    else:
        parts += [f"{n} {fate}" for fate, n in status.fates.items() if n and fate != Fate.IN_BIN]
    what = "steps" if status.fates is None else "scans"
    done = f"{sum(status.bins.values())} sorted in {status.steps} {what}"
    print(f"{done}: {', '.join(parts)}" if parts else done)
    for way in ways:
        print(f"{way.when}: {way.command}")
    return 0


def ways_on(status: RunStatus) -> list[NextCommand]:
    """Return what a person can type next, and when."""
    folder, question = status.folder, status.question
    resume = resume_line(folder)
    if status.condition is Condition.FINISHED:
        return []
    if status.condition is Condition.RUNNING:
        asking = read_token(folder) is not None
        return [NextCommand(f"to {verb} it", line(verb, folder)) for verb in ("hold", "stop") if asking]
    if status.pid is not None and standing_hold(folder) is not None and question is None:
        return [NextCommand("to continue it", line("continue", folder))]
    if question is None:
        return [NextCommand("to resume it", resume)]
    if question.settled is not None:
        return [NextCommand(f"answered: {question.settled}; to resume it", resume)]
    return [way_on(folder, way, resume, waits=status.pid is not None) for way in question.ways]


def way_on(folder: Path, way: Way, resume: str, *, waits: bool) -> NextCommand:
    """Return what to type where one way to continue a held run applies."""
    words = [] if way.answer is None else [line("settle", folder, way.answer.value)]
    if way.home is not None:
        words.insert(0, shlex.join(["beltsort", "home", cell_of(folder), str(way.home), "--live"]))
    if waits:
        words += [] if words else ["answer at the terminal of the run"]
    else:
        words.append(resume)
    return NextCommand(way.when, " && ".join(words))


def line(verb: str, folder: Path, *words: str) -> str:
    """Return a command line about a run."""
    return shlex.join(["beltsort", verb, str(folder), *words])


def resume_line(folder: Path) -> str:
    """Return the command line that resumes a run, without options that it was started with."""
    words = ["beltsort", "run", cell_of(folder)]
    words += [] if folder.name.endswith(DRY_RUN) else ["--live"]
    return shlex.join([*words, "--resume", str(folder)])


def cell_of(folder: Path) -> str:
    """Return the path of a run's cell file, or what stands for it."""
    cell = cell_file_of(folder)
    return "CELL.toml" if cell is None else str(cell)
