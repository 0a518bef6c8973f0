"""`beltsort reproduce`: run the paper's experiments."""

from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from beltsort.cli.arguments import Subparsers, add_json
from beltsort.cli.output import print_json, print_status, print_table
from beltsort.cli.progress import tenths
from beltsort.util.extras import require

if TYPE_CHECKING:
    from beltsort.paper import Reproduction

FOLDER = "reproduction"

EXAMPLE = "beltsort reproduce --quick -o reproduction"


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser: ArgumentParser = subparsers.add_parser(
        "reproduce",
        help="run the paper's experiments; write figures, tables and a report",
        description="Run the paper's experiments, with labels drawn from tables and from depth scans, and "
        "write the figures (PNG, SVG), the numbers (CSV) and a report (HTML) to a folder. An interrupted run "
        "resumes if started again with the same folder. The full run takes about three quarters of an hour "
        "on two idle cores.",
    )
    parser.add_argument(
        "--quick",
        action="store_true",
        help="few batches, three penalties for depth scans, no discount of 0.99, at most three positions; "
        "takes under four minutes",
    )
    parser.add_argument(
        "-o", "--output", type=Path, default=Path(FOLDER), metavar="FOLDER", help=f"(default: {FOLDER})"
    )
    parser.add_argument("--workers", type=int, metavar="N", help="processes (default: one for each core)")
    parser.add_argument("--seed", type=int, default=0, metavar="S", help="seed (default: 0)")
    add_json(parser)
    parser.set_defaults(run=run)


def run(arguments: Namespace) -> int:
    """Run, write and print which claims hold."""
    require("cell", "open3d", "scipy", "matplotlib")
    from beltsort.paper import FULL, QUICK, reproduce
    from beltsort.sim.demo import check_seed
    from beltsort.sim.prepare import prepare
    from beltsort.sorting.runs import make_folder
    from beltsort.util.processes import at_least_one

    # Arguments are checked before minutes are spent on simulations.
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
    """Return the findings and the written files as plain data."""
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
    print_status(f"written: {done.report}, {len(done.tables)} tables, {len(done.pictures)} figures")
