"""`beltsort reproduce`: the paper's experiments from one command."""

from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from beltsort.cli.arguments import Subparsers, add_json
from beltsort.cli.output import print_json, print_table, tell
from beltsort.cli.progress import tenths

if TYPE_CHECKING:
    from beltsort.paper import Reproduction

FOLDER = "reproduction"


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser: ArgumentParser = subparsers.add_parser(
        "reproduce",
        help="run the paper's experiments; write figures, tables and a report",
        description="Run the paper's experiments, with labels drawn from tables and from depth scans, and "
        "write every figure (PNG, SVG), the numbers (CSV) and one report (HTML) into a folder. A run that "
        "broke off goes on if started again with the same folder. The full run takes about half an hour of "
        "two idle cores, and two minutes more for training and tables the first time.",
    )
    parser.add_argument(
        "--quick",
        action="store_true",
        help="few batches, three penalties for depth scans, no discount of 0.99, at most three positions: "
        "under three minutes once tables are cached",
    )
    parser.add_argument(
        "-o", "--output", type=Path, default=Path(FOLDER), metavar="FOLDER", help=f"default: {FOLDER}"
    )
    parser.add_argument("--workers", type=int, metavar="N", help="processes (default: one for each core)")
    parser.add_argument("--seed", type=int, default=0, metavar="S", help="of everything (default: 0)")
    add_json(parser)
    parser.set_defaults(run=run)


def run(arguments: Namespace) -> int:
    """Run, write and print which claims hold."""
    from beltsort.paper import FULL, QUICK, reproduce
    from beltsort.sim.demo import check_seed
    from beltsort.sim.prepare import prepare
    from beltsort.sorting.runs import make_folder
    from beltsort.util.processes import at_least_one

    # Whatever can be refused is refused before minutes are spent.
    check_seed(arguments.seed)
    if arguments.workers is not None:
        at_least_one("workers", arguments.workers)
    make_folder(arguments.output)
    done = reproduce(
        prepare(progress=tenths),
        arguments.output,
        QUICK if arguments.quick else FULL,
        seed=arguments.seed,
        workers=arguments.workers,
        stage=tenths,
        command=arguments.command_line,
    )
    if arguments.json:
        print_json(as_json(done, arguments))
    else:
        show_text(done)
    return 0


def as_json(done: "Reproduction", arguments: Namespace) -> dict[str, Any]:
    """Say what was found and written as plain data."""
    return {
        "command_line": arguments.command_line,
        "seed": arguments.seed,
        "quick": arguments.quick,
        "report": str(done.report),
        "tables": [str(path) for path in done.tables],
        "figures": [picture.name for picture in done.pictures],
        "seconds": {name: round(value, 1) for name, value in done.results.seconds.items()},
        "findings": [result.plain() for result in done.results.claims()],
    }


def show_text(done: "Reproduction") -> None:
    """Print which claims hold, by condition."""
    where = ""
    for result in done.results.claims():
        if result.where != where:
            where = result.where
            print(f"\n{where}")
        print_table([[f"{result.conclusion}:", result.claim]])
        print(f"    {result.text}")
    tell(f"written: {done.report}, {len(done.tables)} tables, {len(done.pictures)} figures")
