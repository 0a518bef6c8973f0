"""`beltsort demo`: the main job on the simulated cell."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from beltsort.cli.arguments import Subparsers, add_json
from beltsort.cli.output import print_json
from beltsort.cli.watching import listening, stages

if TYPE_CHECKING:
    from rich.console import Console

    from beltsort.experiments.demo import DemoResult
    from beltsort.tables.prepare import Prepared


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "demo",
        help="sort ten bulbs from simulated depth scans",
        description="Train the classifier, estimate the observation tables, then sort ten bulbs from depth "
        "scans. Training and tables are made once and cached.",
    )
    parser.add_argument(
        "--seed", type=int, default=0, help="seed of objects, sensor noise and planner (default 0)"
    )
    parser.add_argument(
        "--objects-per-row",
        type=int,
        default=100,
        metavar="N",
        help="independent objects per row of the observation tables (default 100)",
    )
    parser.add_argument(
        "--training-objects",
        type=int,
        default=40,
        metavar="N",
        help="objects per class, viewpoint and position that the classifier is trained on (default 40)",
    )
    add_json(parser)
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Run the command."""
    from rich.console import Console

    from beltsort.experiments.demo import as_json, check_seed, run_demo
    from beltsort.runs import make_folder, run_name
    from beltsort.tables.prepare import prepare

    console = Console(stderr=arguments.json, highlight=False, soft_wrap=True)
    # Whatever can be refused is refused before minutes are spent.
    check_seed(arguments.seed)
    runs = make_folder(Path("runs"))
    with stages(console) as stage:
        prepared = prepare(
            training_objects=arguments.training_objects,
            table_objects=arguments.objects_per_row,
            progress=stage,
        )
    _tell_tables(console, prepared)
    with listening(console) as listener:
        result = run_demo(prepared, arguments.seed, make_folder(runs / run_name()), listener)
    _tell_result(console, result)
    if arguments.json:
        print_json(as_json(result, arguments.seed))
    return 0


def _tell_tables(console: "Console", prepared: "Prepared") -> None:
    from beltsort.cell.simulated import CellConfig
    from beltsort.tables import agreement_text, table_one, table_two

    config = CellConfig()
    names = [viewpoint.name for viewpoint in config.viewpoints]
    tables = prepared.counts.probabilities(1.0)
    where = "from the cache" if prepared.cached else "estimated now"
    scans = prepared.counts.counts.sum(axis=-1)
    per_row = f"{scans.min()}" if scans.min() == scans.max() else f"{scans.min()} to {scans.max()}"
    console.print(f"observation tables {where}: {per_row} scans per row, each of another object")
    console.print(table_one(tables, config.classes, names, true=0), markup=False)
    console.print(table_two(tables, config.classes, names, trues=(0, 1)), markup=False)
    console.print(agreement_text(prepared.counts, names), markup=False)


def _tell_result(console: "Console", result: "DemoResult") -> None:
    decided = len(result.report.decisions)
    console.print(f"{result.correct} of {decided} right in {result.report.steps} steps")
    console.print(f"journal, model and picture: {result.folder}")
