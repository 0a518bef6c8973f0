"""`beltsort reproduce`: run the paper's experiments."""

from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from beltsort.cli.arguments import Subparsers, add_json
from beltsort.cli.output import print_json, print_status, print_table
from beltsort.cli.progress import tenths
from beltsort.util.extras import require

if TYPE_CHECKING:
    from beltsort.paper import Redrawn

FOLDER = "reproduction"

EXAMPLE = "beltsort reproduce --quick -o reproduction"


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser: ArgumentParser = subparsers.add_parser(
        "reproduce",
        help="run the paper's experiments; write figures, tables and a report",
        description="Run the paper's experiments, with labels drawn from tables and from depth scans, and "
        "write the figures (PNG, SVG, PDF), the numbers (CSV) and a report (HTML) to a folder. An "
        "interrupted run resumes if started again with the same folder. The full run takes about three "
        "quarters of an hour on two idle cores. --from draws figures and report again from the numbers "
        "of an earlier run.",
    )
    what = parser.add_mutually_exclusive_group()
    what.add_argument(
        "--quick",
        action="store_true",
        help="few batches, three penalties for depth scans, no discount of 0.99, at most three positions; "
        "takes under four minutes",
    )
    what.add_argument(
        "--from",
        dest="source",
        type=Path,
        metavar="FOLDER",
        help="draw figures and report from the CSV files of this folder, and run nothing",
    )
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="FOLDER",
        help=f"(default: {FOLDER}, or with --from its own folder)",
    )
    parser.add_argument("--workers", type=int, metavar="N", help="processes (default: one for each core)")
    parser.add_argument("--seed", type=int, default=0, metavar="S", help="seed (default: 0)")
    add_json(parser)
    parser.set_defaults(run=run)


def run(arguments: Namespace) -> int:
    """Run, write and print which claims hold."""
    require("cell", "open3d", "scipy", "matplotlib")
    from beltsort.paper import FULL, QUICK, redraw, reproduce
    from beltsort.sim.demo import check_seed
    from beltsort.sim.prepare import prepare
    from beltsort.sorting.runs import make_folder
    from beltsort.util.processes import at_least_one

    # Arguments are checked before minutes are spent on simulations.
    check_seed(arguments.seed)
    if arguments.workers is not None:
        at_least_one("workers", arguments.workers)
    output = arguments.output or arguments.source or Path(FOLDER)
    make_folder(output)
    done: Redrawn
    if arguments.source is not None:
        done = redraw(prepare(progress=tenths), arguments.source, output)
    else:
        done = reproduce(
            prepare(progress=tenths),
            output,
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


def as_json(done: "Redrawn", arguments: Namespace) -> dict[str, Any]:
    """Return the findings and the written files as plain data."""
    from beltsort.paper import Reproduction

    ran = done if isinstance(done, Reproduction) else None
    about = done.numbers.circumstances
    return {
        "command_line": arguments.command_line,
        "seed": about.seed,
        "quick": about.quick,
        "report": str(done.report),
        "tables": [] if ran is None else [str(path) for path in ran.tables],
        "figures": [picture.name for picture in done.pictures],
        "seconds": {} if ran is None else {name: round(s, 1) for name, s in ran.results.seconds.items()},
        "findings": [result.plain() for result in done.numbers.findings],
    }


def show_text(done: "Redrawn") -> None:
    """Print which claims hold, by condition."""
    where = ""
    for result in done.numbers.findings:
        if result.where != where:
            where = result.where
            print(f"\n{where}")
        print_table([[f"{result.conclusion}:", result.claim]])
        print(f"    {result.text}")
    print_status(f"written: {done.report}, {len(done.pictures)} figures")
