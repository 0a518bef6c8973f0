"""`beltsort backup`: copy a run, also while it goes on."""

from argparse import Namespace
from pathlib import Path

from beltsort.cli.arguments import Subparsers, add_json
from beltsort.cli.output import print_json
from beltsort.cli.show import add_run

EXAMPLE = "beltsort backup runs/2026-01-31T12-00-00.000000Z /mnt/backup/monday"


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "backup",
        help="copy a run, also while it goes on",
        description="Copy a run, which may be in progress, and check the copy by reading it. Nothing is "
        "replaced. docs/journal.md describes what is copied, and how a copy is resumed.",
    )
    add_run(parser)
    parser.add_argument(
        "target",
        metavar="FILE|FOLDER",
        type=Path,
        help="a new folder for the whole run, or a new file that ends in .sqlite for its journal alone",
    )
    add_json(parser)
    parser.set_defaults(run=run)


def run(arguments: Namespace) -> int:
    """Copy, and print what was copied."""
    from beltsort.sorting.backup import backup_run

    backup = backup_run(arguments.folder, arguments.target)
    if arguments.json:
        print_json(
            {
                "target": str(arguments.target),
                "journal": str(backup.path),
                "first_entry": backup.first,
                "last_entry": backup.last,
                "at_belt_end": backup.index,
            }
        )
    else:
        print(
            f"{arguments.target}: entries {backup.first} to {backup.last}, read back; the next object is "
            f"{backup.index}"
        )
    return 0
