"""`beltsort export`: write a model in the format of other solvers."""

from argparse import Namespace
from pathlib import Path

from beltsort import ArgumentError
from beltsort.cli.arguments import Subparsers, add_json, add_model, load_model
from beltsort.cli.output import print_json

FORMAT = ".pomdp"

EXAMPLE = "beltsort export paper paper.pomdp"


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "export",
        help="write a model for other solvers",
        description="Write a model as a flat POMDP in Cassandra's format, which other solvers read.",
    )
    add_model(parser)
    parser.add_argument("file", metavar="FILE", type=Path, help=f"where to write; ends in {FORMAT}")
    add_json(parser)
    parser.set_defaults(run=run)


def run(arguments: Namespace) -> int:
    """Write the file."""
    if arguments.file.suffix != FORMAT:
        raise ArgumentError(
            f"FILE is {arguments.file}, expected a name that ends in {FORMAT}, the only format; rename it"
        )
    load_model(arguments).to_pomdp(arguments.file)
    written = arguments.file.stat().st_size
    if arguments.json:
        print_json({"file": str(arguments.file), "bytes": written})
    else:
        print(f"{arguments.file}: {written} bytes")
    return 0
