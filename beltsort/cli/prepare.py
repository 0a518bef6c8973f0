"""`beltsort prepare`: compute classifier and observation tables of the default simulated cell."""

from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from beltsort import ArgumentError
from beltsort.cli.arguments import Subparsers, add_json
from beltsort.cli.output import print_json, print_table
from beltsort.cli.progress import tenths
from beltsort.sim.config import TABLE_OBJECTS, TRAINING_OBJECTS

if TYPE_CHECKING:
    from beltsort.sim.prepare import Recipe

DESCRIPTION = """
Train the classifier of the default simulated cell, label the scans for its observation tables, and write both
to a folder, with the settings and versions (about.json). In a checkout, `-o beltsort/models/simulated_cell`
updates the files that come with the package.
"""

EXAMPLE = "beltsort prepare -o simulated_cell"


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "prepare",
        help="compute classifier and tables of the default simulated cell",
        description=DESCRIPTION,
    )
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        required=True,
        metavar="FOLDER",
        help="output folder; one that `beltsort prepare` wrote before is replaced",
    )
    add_objects(parser)
    add_json(parser)
    parser.set_defaults(run=run)


def add_objects(parser: ArgumentParser) -> None:
    """Add the numbers of objects for training and for the tables; `recipe_of` reads them."""
    parser.add_argument(
        "--objects-per-row",
        type=int,
        metavar="N",
        help=f"independent objects per row of the observation tables (default: {TABLE_OBJECTS})",
    )
    parser.add_argument(
        "--training-objects",
        type=int,
        metavar="N",
        help=f"training objects per class, viewpoint and position (default: {TRAINING_OBJECTS})",
    )


def recipe_of(arguments: Namespace) -> "Recipe":
    """Return the recipe with the numbers of objects in the arguments."""
    from beltsort.sim.prepare import Recipe

    given = {
        "training_objects": arguments.training_objects,
        "table_objects": arguments.objects_per_row,
    }
    return Recipe(**{name: number for name, number in given.items() if number is not None})


def run(arguments: Namespace) -> int:
    """Train, label and store."""
    from beltsort.sim.prepare import ABOUT, make

    recipe, folder = recipe_of(arguments), arguments.output
    if folder.exists() and not (folder / ABOUT).exists():
        raise ArgumentError(
            f"{folder} exists and contains no {ABOUT}, expected a new folder or one that `beltsort prepare` "
            "wrote: name another"
        )
    seconds = make(recipe, folder, tenths).seconds
    sizes = {file.name: file.stat().st_size for file in sorted(folder.iterdir())}
    if arguments.json:
        print_json({"folder": str(folder), "key": recipe.key(), "bytes": sizes, "seconds": seconds})
    else:
        print_table([(name, f"{size} bytes") for name, size in sizes.items()])
    return 0
