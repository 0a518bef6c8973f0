"""`beltsort throughput`: how many objects a minute a cell sorts on a belt that never stops."""

from argparse import Namespace
from pathlib import Path

from beltsort import ArgumentError
from beltsort.cli.arguments import Subparsers, add_json, add_model, check_writable, load_model
from beltsort.cli.output import print_json
from beltsort.cli.progress import terminal_progress
from beltsort.planning.named_moving_policy import HELP
from beltsort.planning.throughput import OBJECTS, PURITY, RUNS, ArmTimes, throughput
from beltsort.planning.throughput.figure import draw_throughput
from beltsort.planning.throughput.table import throughput_table
from beltsort.util.extras import require

SPEEDS = (10.0, 20.0, 30.0, 40.0)
POLICIES = ("moving-search:1", "most-urgent:0.95", "stop-and-go:threshold:0.94")
TIMES = ArmTimes()

EXAMPLE = "beltsort throughput paper --speeds 10 20 --runs 20 --purity 0.9"


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "throughput",
        help="objects per minute and purity on a belt that never stops, by belt speed and policy",
        description="Simulate policies on a belt that never stops, at several speeds and on the same "
        "objects: shares of right, wrong and missed objects, purity of the least pure bin, objects decided "
        "per minute, reward per object, each with a 95 % interval, and the 99th percentile of the time of a "
        "plan.",
    )
    add_model(parser)
    parser.add_argument(
        "--speeds",
        type=float,
        nargs="+",
        default=list(SPEEDS),
        metavar="V",
        help="belt speeds in places per minute, or with --spacing in metres per second (default: "
        f"{' '.join(f'{speed:g}' for speed in SPEEDS)})",
    )
    parser.add_argument("--spacing", type=float, metavar="M", help="metres between two places of the belt")
    for name, what in (
        ("move", "a move of the camera"),
        ("scan", "a scan and its labels"),
        ("sort", "a decision in which the arm does nothing else"),
        ("tick", "a tick"),
    ):
        parser.add_argument(
            f"--{name}",
            type=float,
            default=getattr(TIMES, name),
            metavar="S",
            help=f"seconds of {what} (default: {getattr(TIMES, name):g})",
        )
    parser.add_argument(
        "--reach",
        type=int,
        metavar="N",
        help="places, from the exit, at which objects can be decided (default: all)",
    )
    parser.add_argument(
        "--missed",
        type=float,
        metavar="PRICE",
        help="price of an object that passes the exit undecided (default: the largest reward, 0 for empty "
        "cups)",
    )
    parser.add_argument(
        "--policies",
        nargs="+",
        default=list(POLICIES),
        metavar="POLICY",
        help=f"{HELP} (default: {' '.join(POLICIES)})",
    )
    for name, what, number in (
        ("purity", "purity to hold in every bin", PURITY),
        ("objects", "objects of a run", OBJECTS),
        ("runs", "number of runs", RUNS),
        ("seed", "seed of objects and labels", 0),
    ):
        parser.add_argument(
            f"--{name}", type=type(number), default=number, metavar="N", help=f"{what} (default: {number})"
        )
    parser.add_argument("--figure", type=Path, metavar="FILE", help="draw the results (png, svg or pdf)")
    add_json(parser)
    parser.set_defaults(run=run)


def run(arguments: Namespace) -> int:
    """Simulate, draw and print."""
    model = load_model(arguments)
    if arguments.figure is not None:
        check_writable(arguments.figure)
        require("plot", "matplotlib")
    with terminal_progress("policies") as progress:
        found = throughput(
            model,
            arguments.policies,
            _places_per_minute(arguments),
            ArmTimes(arguments.move, arguments.scan, arguments.sort, arguments.tick),
            reach=arguments.reach,
            missed=arguments.missed,
            purity=arguments.purity,
            objects=arguments.objects,
            runs=arguments.runs,
            seed=arguments.seed,
            progress=progress,
        )
    if arguments.figure is not None:
        draw_throughput(found, arguments.figure)
    if arguments.json:
        print_json({"command_line": arguments.command_line, **found.to_dict()})
    else:
        print(throughput_table(found))
        print(f"Made by: {arguments.command_line}")
    return 0


def _places_per_minute(arguments: Namespace) -> list[float]:
    spacing: float | None = arguments.spacing
    if spacing is None:
        return list(arguments.speeds)
    if not spacing > 0:
        raise ArgumentError(f"--spacing is {spacing:g} m, expected a distance above 0: correct it")
    return [60 * speed / spacing for speed in arguments.speeds]
