"""`beltsort example`: print a cell file to start from."""

from argparse import Namespace
from pathlib import Path

from beltsort import ArgumentError
from beltsort.cellfile.example import example, examples
from beltsort.cli.arguments import Subparsers, add_json
from beltsort.cli.output import print_json, print_status, print_table

EXAMPLE = "beltsort example"


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "example",
        help="print a cell file to start from",
        description="Print a cell file that comes with the package, to start your own from. Without NAME, "
        "list them.",
    )
    parser.add_argument("name", metavar="NAME", nargs="?", help="name of the cell file")
    parser.add_argument("-o", "--output", type=Path, metavar="CELL.toml", help="write it to a new file")
    add_json(parser)
    parser.set_defaults(run=run)


def run(arguments: Namespace) -> int:
    """Print or write."""
    output: Path | None = arguments.output
    if arguments.name is None:
        if output is not None:
            raise ArgumentError(
                f"-o {output} is given without NAME, expected the cell file to write; name one"
            )
        titles = {each.name: each.title for each in examples()}
        if arguments.json:
            print_json({"examples": titles})
        else:
            print_table(list(titles.items()))
        return 0
    text = example(arguments.name).text
    if output is not None:
        with output.open("x", encoding="utf-8") as file:  # a cell file that was edited is not overwritten
            file.write(text)
        print_status(f"written: {output}")
    if arguments.json:
        print_json({"name": arguments.name, "file": None if output is None else str(output), "text": text})
    elif output is None:
        print(text, end="")
    return 0
