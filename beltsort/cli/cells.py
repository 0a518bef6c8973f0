"""What the commands about a cell share."""

from argparse import ArgumentParser
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console

    from beltsort.cellfile.composed import ComposedCell
    from beltsort.cellfile.description import CellDescription


def add_cell(parser: ArgumentParser) -> None:
    """Add the cell file, and whether anything may move."""
    parser.add_argument("cell", metavar="CELL.toml", help="a cell file: see docs/cell.md")
    parser.add_argument(
        "--live",
        action="store_true",
        help="move things; without it, devices that could move something real only say what they would do",
    )


def tell_pretence(console: "Console", description: "CellDescription", cell: "ComposedCell") -> None:
    """Say what only pretends to move, and that some failures are meant."""
    if description.faults is not None:
        console.print("faults on purpose are on; remove [faults] from the cell file to sort in earnest")
    if cell.rehearsed:
        devices = ", ".join(cell.rehearsed)
        console.print(f"dry run: {devices} move nothing and say what they would do; --live moves them")
