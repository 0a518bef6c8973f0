"""`beltsort demo`: sort ten bulbs with the simulated cell."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from beltsort.cli.arguments import Subparsers, add_json, add_rrd
from beltsort.cli.output import print_json, print_recording, print_status
from beltsort.cli.prepare import add_objects, recipe_of
from beltsort.cli.progress import stage_progress
from beltsort.util.extras import require

if TYPE_CHECKING:
    from rich.console import Console

    from beltsort.sim.prepare import Prepared

EXAMPLE = "beltsort demo"


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "demo",
        help="sort ten bulbs from simulated depth scans",
        description="Sort ten bulbs from simulated depth scans. Classifier and observation tables come with "
        "the package; for other numbers of objects they are computed once and cached.",
    )
    parser.add_argument(
        "--seed", type=int, default=0, help="seed of objects, sensor noise and planner (default: 0)"
    )
    add_objects(parser)
    add_rrd(parser)
    add_json(parser)
    parser.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Run the command."""
    require("cell", "open3d", "scipy", "matplotlib", "pydantic")
    from beltsort.cli.console import RunConsole
    from beltsort.cli.live import run_display
    from beltsort.planning.bins import sorting_statistics
    from beltsort.rrd.package import load_rerun
    from beltsort.sim.demo import as_json, check_seed, run_demo
    from beltsort.sim.prepare import prepare
    from beltsort.sorting.runs import make_folder, run_name

    console = RunConsole(stderr=arguments.json)
    # Arguments are checked before minutes are spent on training.
    check_seed(arguments.seed)
    if arguments.rrd is not None:
        load_rerun()
    recipe = recipe_of(arguments)
    runs = make_folder(Path("runs"))
    with stage_progress(console) as stage:
        prepared = prepare(recipe, progress=stage)
    _print_tables(console, prepared)
    with run_display(console) as listener:
        folder = make_folder(runs / run_name())
        result = run_demo(prepared, arguments.seed, folder, listener, rrd=arguments.rrd, say=print_status)
    console.print(f"{result.correct} of {len(result.report.decisions)} right in {result.report.steps} steps")
    console.print(f"\nobjects by bin and true class:\n{sorting_statistics(result.model, result.confusion)}")
    console.print(f"journal, model and figure: {result.folder}")
    print_recording(arguments.rrd)
    if arguments.json:
        print_json(as_json(result, arguments.seed))
    return 0


def _print_tables(console: "Console", prepared: "Prepared") -> None:
    from beltsort.sim import CellConfig
    from beltsort.tables import agreement_text, table_one, table_two

    config = CellConfig()
    names = [viewpoint.name for viewpoint in config.viewpoints]
    tables = prepared.counts.probabilities(1.0)
    where = {"package": "from the package", "cache": "from the cache", "made": "estimated now"}[
        prepared.source
    ]
    scans = prepared.counts.counts.sum(axis=-1)
    per_row = f"{scans.min()}" if scans.min() == scans.max() else f"{scans.min()} to {scans.max()}"
    console.print(f"observation tables {where}: {per_row} scans per row, each of another object")
    console.print(table_one(tables, config.classes, names, true=0))
    console.print(table_two(tables, config.classes, names))
    console.print(agreement_text(prepared.counts, names))
