"""`beltsort continue`: continue a run that a person has asked to hold."""

from beltsort.cli.arguments import Subparsers
from beltsort.cli.asking import add_request

EXAMPLE = "beltsort continue latest"


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    add_request(
        subparsers,
        "continue",
        "continue a run that is held by request",
        "Continue a run that `beltsort hold` or the page of `beltsort watch` holds.",
        "continues",
    )
