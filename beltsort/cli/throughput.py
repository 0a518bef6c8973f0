"""`beltsort throughput`: how many objects a minute a cell sorts on a belt that never stops."""

from argparse import Namespace
from dataclasses import replace
from pathlib import Path

from beltsort import ArgumentError
from beltsort.cli.arguments import MODEL_HELP, Subparsers, add_json, add_model, check_writable, load_model
from beltsort.cli.output import print_json
from beltsort.cli.progress import stage_progress, terminal_progress
from beltsort.planning.named_moving_policy import HELP
from beltsort.planning.throughput import (
    CELL_OBJECTS,
    CELL_RUNS,
    OBJECTS,
    PURITY,
    RUNS,
    ArmTimes,
    Throughput,
    throughput,
)
from beltsort.planning.throughput.figure import draw_throughput
from beltsort.planning.throughput.table import throughput_table
from beltsort.util.extras import require

SPEEDS = (10.0, 20.0, 30.0, 40.0)
POLICIES = ("moving-search:1", "most-urgent:0.95", "stop-and-go:threshold:0.94")
TIMES = ArmTimes()
CELL = ".toml"
OF_MODELS = ("positions", "set", "spacing", "move", "scan", "sort", "tick", "reach", "missed")
"""Options that are for models: a cell file says itself what they do."""

EXAMPLE = "beltsort throughput paper --speeds 10 20 --runs 20 --purity 0.9"


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "throughput",
        help="objects per minute and purity on a belt that never stops, by belt speed and policy",
        description="Simulate policies on a belt that never stops, at several speeds and on the same "
        "objects: shares of right, wrong and missed objects, purity of the least pure bin, objects decided "
        "per minute, reward per object, each with a 95 % interval, and the 99th percentile of the time of a "
        "plan. For a model, labels are drawn from its tables; for a simulated cell with a table [moving], "
        "depth scans are rendered, and the sorting loop sorts, at about a fifth of a second for each cup.",
    )
    add_model(parser, f"{MODEL_HELP}; or a cell file (TOML)")
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
    parser.add_argument(
        "--purity",
        type=float,
        default=PURITY,
        metavar="P",
        help=f"purity to hold in every bin (default: {PURITY:g})",
    )
    for name, what in (
        ("objects", f"objects of a run (default: {OBJECTS}; {CELL_OBJECTS} of a cell, empty cups included)"),
        ("runs", f"number of runs (default: {RUNS}; {CELL_RUNS} of a cell)"),
        ("seed", "seed of objects and labels (default: 0; of a cell the cell file's)"),
    ):
        parser.add_argument(f"--{name}", type=int, metavar="N", help=what)
    parser.add_argument("--figure", type=Path, metavar="FILE", help="draw the results (png, svg or pdf)")
    add_json(parser)
    parser.set_defaults(run=run)


def run(arguments: Namespace) -> int:
    """Simulate, draw and print."""
    if arguments.figure is not None:
        check_writable(arguments.figure)
        require("plot", "matplotlib")
    simulate = _of_cell if arguments.model.endswith(CELL) else _of_model
    found = simulate(arguments)
    if arguments.figure is not None:
        draw_throughput(found, arguments.figure)
    if arguments.json:
        print_json({"command_line": arguments.command_line, **found.to_dict()})
    else:
        print(throughput_table(found))
        print(f"Made by: {arguments.command_line}")
    return 0


def _of_model(arguments: Namespace) -> Throughput:
    """Return the study of a model."""
    model = load_model(arguments)
    seconds = {name: getattr(arguments, name) for name in ("move", "scan", "sort", "tick")}
    with terminal_progress("policies") as progress:
        return throughput(
            model,
            arguments.policies,
            _places_per_minute(arguments),
            replace(TIMES, **{name: value for name, value in seconds.items() if value is not None}),
            reach=arguments.reach,
            missed=arguments.missed,
            purity=arguments.purity,
            objects=_given(arguments.objects, OBJECTS),
            runs=_given(arguments.runs, RUNS),
            seed=_given(arguments.seed, 0),
            progress=progress,
        )


def _of_cell(arguments: Namespace) -> Throughput:
    """Return the study of a simulated cell.

    Raises
    ------
    ArgumentError
        If an option is given that is for models.
    """
    from beltsort.cellfile.description import CellDescription
    from beltsort.cellfile.throughput import cell_throughput
    from beltsort.cli.console import RunConsole

    if given := [f"--{name}" for name in OF_MODELS if getattr(arguments, name) not in (None, [])]:
        raise ArgumentError(
            f"{', '.join(given)} and a cell file are given, expected a model with it: leave it out, and "
            f"change {arguments.model} instead"
        )
    arguments.cell = arguments.model  # named by the message of an error
    description = CellDescription.load(arguments.cell)
    console = RunConsole(stderr=True)
    with stage_progress(console) as stage:
        return cell_throughput(
            description,
            arguments.policies,
            arguments.speeds,
            purity=arguments.purity,
            objects=_given(arguments.objects, CELL_OBJECTS),
            runs=_given(arguments.runs, CELL_RUNS),
            seed=arguments.seed,
            stage=stage,
            progress=stage("runs"),
        )


def _given(number: int | None, default: int) -> int:
    return default if number is None else number


def _places_per_minute(arguments: Namespace) -> list[float]:
    spacing: float | None = arguments.spacing
    if spacing is None:
        return list(arguments.speeds)
    if not spacing > 0:
        raise ArgumentError(f"--spacing is {spacing:g} m, expected a distance above 0: correct it")
    return [60 * speed / spacing for speed in arguments.speeds]
