"""`beltsort home`: set the position of a belt."""

from argparse import Namespace

from beltsort import ArgumentError
from beltsort.cli.arguments import Subparsers, add_cell, add_json
from beltsort.cli.output import print_json

DESCRIPTION = """
Set the number of the object at the belt end, after you have checked it: when the belt's controller was
started, or after a fault. Nothing moves. No other command homes a belt on its own.
"""

EXAMPLE = "beltsort home cell.toml 12 --live"


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "home", help="set the number of the object at the belt end", description=DESCRIPTION
    )
    add_cell(parser)
    parser.add_argument(
        "object", type=int, metavar="OBJECT", help="number of the object at the belt end, as in the run"
    )
    add_json(parser)
    parser.set_defaults(run=run)


def run(arguments: Namespace) -> int:
    """Home the belt."""
    from beltsort.cellfile.composed import compose
    from beltsort.cellfile.description import CellDescription
    from beltsort.cellfile.run import home
    from beltsort.sorting.locks import devices_locked

    if arguments.object < 0:
        raise ArgumentError(
            f"OBJECT is {arguments.object}, expected at least 0; give the object's number in the run"
        )
    devices: list[object] = []
    compose(
        CellDescription.load(arguments.cell), live=arguments.live, say=lambda _line: None, made=devices.append
    )
    if arguments.live:
        with devices_locked(devices):
            home(devices, arguments.object)
    if arguments.json:
        print_json({"object": arguments.object, "told": arguments.live})
    elif arguments.live:
        print(f"the belt was homed: object {arguments.object} is at the belt end")
    else:
        print(f"dry run: the belt was not homed to object {arguments.object}; --live homes it")
    return 0
