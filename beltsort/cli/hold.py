"""`beltsort hold`: hold a run after its current step."""

from beltsort.cli.arguments import Subparsers
from beltsort.cli.asking import add_request

EXAMPLE = "beltsort hold latest"


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    add_request(
        subparsers,
        "hold",
        "hold a run after its current step",
        "Hold a run after its current step, until `beltsort continue`. This is no safety function.",
        "holds after this step",
    )
