"""`beltsort migrate`: make a journal of an older version one of today's."""

from argparse import Namespace

from beltsort.cli.arguments import Subparsers, add_json
from beltsort.cli.output import print_json, print_status
from beltsort.cli.show import add_run

EXAMPLE = "beltsort migrate runs/2026-01-31T12-00-00.000000Z"


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "migrate",
        help="make the journal of an older version one of today's",
        description="Make the journal of a run one of today's version, to be shown and explained. The old "
        "one is kept beside it. What it did not record is said.",
    )
    add_run(parser)
    add_json(parser)
    parser.set_defaults(run=run)


def run(arguments: Namespace) -> int:
    """Migrate, and print what became of the journal."""
    from beltsort.sorting.migration import migrate

    migrated = migrate(arguments.folder)
    for note in migrated.notes:
        print_status(f"beltsort: {note}")
    if arguments.json:
        kept = None if migrated.kept is None else str(migrated.kept)
        print_json(
            {
                "journal": str(migrated.path),
                "kept": kept,
                "entries": migrated.entries,
                "notes": list(migrated.notes),
            }
        )
    elif migrated.kept is None:
        print(f"{migrated.path} is of today's version already: {migrated.entries} entries")
    else:
        print(f"{migrated.path}: {migrated.entries} entries; the old journal is {migrated.kept}")
    return 0
