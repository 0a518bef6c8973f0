"""`beltsort home`: tell a belt where it stands."""

from argparse import Namespace

from beltsort import ArgumentError
from beltsort.cli.arguments import Subparsers, add_json
from beltsort.cli.cells import add_cell
from beltsort.cli.output import print_json

DESCRIPTION = """
Tell the belt which object is at the belt end, after you have looked: when its controller was started, or
after a fault. Nothing moves. No other command ever does this by itself.
"""


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "home", help="tell the belt which object is at its end", description=DESCRIPTION
    )
    add_cell(parser)
    parser.add_argument("object", type=int, metavar="OBJECT", help="its number, as the run counts")
    add_json(parser)
    parser.set_defaults(run=run)


def run(arguments: Namespace) -> int:
    """Home the belt."""
    from beltsort.cellfile.composed import compose
    from beltsort.cellfile.description import CellDescription
    from beltsort.cellfile.run import home
    from beltsort.sorting.locks import devices_locked

    if arguments.object < 0:
        raise ArgumentError(f"OBJECT is {arguments.object}, expected a number from 0 on")
    devices: list[object] = []
    compose(
        CellDescription.load(arguments.cell), live=arguments.live, say=lambda _line: None, made=devices.append
    )
    if arguments.live:
        with devices_locked(devices):
            home(devices, arguments.object)
    said = "the belt was told" if arguments.live else "without --live nobody was told"
    if arguments.json:
        print_json({"object": arguments.object, "told": arguments.live})
    else:
        print(f"{said} that object {arguments.object} is at the belt end")
    return 0
