"""`beltsort prune`: remove old runs."""

import re
from argparse import ArgumentTypeError, Namespace
from datetime import timedelta
from pathlib import Path

from beltsort import ArgumentError
from beltsort.cli.arguments import Subparsers, add_json
from beltsort.cli.output import print_json
from beltsort.sorting.runs import RUNS
from beltsort.util.text import counted

EXAMPLE = "beltsort prune runs --keep 20 --older-than 30d"

UNITS = {"h": timedelta(hours=1), "d": timedelta(days=1), "w": timedelta(weeks=1)}


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "prune",
        help="remove old runs",
        description="Print which runs are old, and with --yes remove their folders: journal, record of "
        "calls, scans and whatever else is in them. A run that is in use or held, that ended during a sort "
        "whose outcome is not known, or that is the newest of its cell is never removed: docs/journal.md.",
    )
    parser.add_argument(
        "folder", metavar="RUNS", nargs="?", type=Path, default=RUNS, help="folder of runs (default: runs)"
    )
    parser.add_argument(
        "--keep",
        type=int,
        metavar="N",
        help="keep the N newest runs of each cell, at least 1; dry runs are counted apart (default: 1)",
    )
    parser.add_argument(
        "--older-than",
        type=age,
        metavar="AGE",
        help="keep runs that were written since: hours, days or weeks ago, as 12h, 30d or 8w",
    )
    parser.add_argument("--yes", action="store_true", help="remove them (default: only print)")
    add_json(parser)
    parser.set_defaults(run=run)


def age(text: str) -> timedelta:
    """Parse an age.

    Examples
    --------
    >>> age("30d")
    datetime.timedelta(days=30)
    """
    parts = re.fullmatch(r"(\d{1,6})([hdw])", text)
    if parts is None:
        raise ArgumentTypeError(f"{text!r}: expected a number of hours, days or weeks, as 12h, 30d or 8w")
    return int(parts[1]) * UNITS[parts[2]]


def run(arguments: Namespace) -> int:
    """Print or remove."""
    from beltsort.sorting.retention import old_runs, prune

    runs: Path = arguments.folder
    if arguments.keep is None and arguments.older_than is None:
        raise ArgumentError("prune needs --keep N, --older-than AGE, or both, to know which runs are old")
    if not runs.is_dir():
        raise ArgumentError(f"{runs} is no folder; name a folder of runs")
    act = prune if arguments.yes else old_runs
    found = act(runs, keep=1 if arguments.keep is None else arguments.keep, older_than=arguments.older_than)
    if arguments.json:
        print_json(
            {
                "removed": arguments.yes,
                "old": [
                    {"folder": str(old.folder), "updated": old.updated.isoformat(), "bytes": old.size}
                    for old in found.old
                ],
                "kept": [{"folder": str(kept.folder), "why": kept.why} for kept in found.kept],
                "bytes": found.size,
            }
        )
        return 0
    for kept in found.kept:
        print(f"kept: {kept.folder}: {kept.why}")
    verb = "removed" if arguments.yes else "would be removed"
    for old in found.old:
        print(f"{verb}: {old.folder}, last written {old.updated:%Y-%m-%d}, {old.size / 1e6:.1f} MB")
    freed = f"{counted(len(found.old), 'run')} {verb}, {found.size / 1e6:.1f} MB"
    print(freed if arguments.yes or not found.old else f"{freed}; --yes removes them")
    return 0
