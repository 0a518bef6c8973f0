"""`beltsort stop`: end a run after its current step."""

from beltsort.cli.arguments import Subparsers
from beltsort.cli.asking import add_request

EXAMPLE = "beltsort stop latest"


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser = add_request(
        subparsers,
        "stop",
        "end a run after its current step",
        "End a run after its current step, with exit code 0, so that a service manager does not start it "
        "again. It can be resumed.",
        "ends after this step",
    )
    parser.add_argument("--wait", action="store_true", help="wait until the run has ended")
