"""`beltsort prepare`: classifier and observation tables of the default simulated cell, made anew."""

from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from beltsort import ArgumentError
from beltsort.cli.arguments import Subparsers, add_json
from beltsort.cli.output import print_json, print_table
from beltsort.cli.progress import tenths

if TYPE_CHECKING:
    from beltsort.sim.prepare import Recipe

DESCRIPTION = """
Train the classifier of the default simulated cell, label the scans of its observation tables, and write
both to a folder, beside what made them (about.json). In a checkout, `-o beltsort/models/simulated_cell` makes
anew what comes with the package.
"""


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "prepare", help="classifier and tables of the default cell, made anew", description=DESCRIPTION
    )
    parser.add_argument(
        "-o", "--output", type=Path, required=True, metavar="FOLDER", help="replaced if it is one of these"
    )
    add_objects(parser)
    add_json(parser)
    parser.set_defaults(run=run)


def add_objects(parser: ArgumentParser) -> None:
    """Add how many objects classifier and tables are made from; `recipe_of` reads them."""
    parser.add_argument(
        "--objects-per-row",
        type=int,
        metavar="N",
        help="independent objects per row of the observation tables (default 100)",
    )
    parser.add_argument(
        "--training-objects",
        type=int,
        metavar="N",
        help="objects per class, viewpoint and position that the classifier is trained on (default 40)",
    )


def recipe_of(arguments: Namespace) -> "Recipe":
    """Return what the arguments ask for."""
    from beltsort.sim.prepare import Recipe

    given = {
        "training_objects": arguments.training_objects,
        "table_objects": arguments.objects_per_row,
    }
    return Recipe(**{name: number for name, number in given.items() if number is not None})


def run(arguments: Namespace) -> int:
    """Make and store."""
    from beltsort.sim.prepare import ABOUT, make

    recipe, folder = recipe_of(arguments), arguments.output
    if folder.exists() and not (folder / ABOUT).exists():
        raise ArgumentError(
            f"{folder} exists and holds no {ABOUT}: name a new folder, or one made by prepare"
        )
    seconds = make(recipe, folder, tenths).seconds
    sizes = {file.name: file.stat().st_size for file in sorted(folder.iterdir())}
    if arguments.json:
        print_json({"folder": str(folder), "key": recipe.key(), "bytes": sizes, "seconds": seconds})
    else:
        print_table([(name, f"{size} bytes") for name, size in sizes.items()])
    return 0
