"""`beltsort service`: print a systemd unit for a cell."""

import getpass
import math
import sys
from argparse import Namespace
from importlib.resources import files
from pathlib import Path
from string import Template

from beltsort import ArgumentError
from beltsort.cli.arguments import Subparsers, add_json
from beltsort.cli.output import print_json, print_status

EXAMPLE = "beltsort service cell.toml -o beltsort.service"


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "service",
        help="print a systemd unit for a cell",
        description="Print a systemd unit that runs a cell as a service of this user in this folder. The "
        "time after which a run counts as hung follows from the timeouts in the cell file: docs/service.md.",
    )
    parser.add_argument("cell", metavar="CELL.toml", help="a cell file: see docs/cell.md")
    parser.add_argument("-o", "--output", type=Path, metavar="FILE", help="write it to a new file")
    add_json(parser)
    parser.set_defaults(run=run)


def run(arguments: Namespace) -> int:
    """Print or write."""
    text = unit_of(Path(arguments.cell))
    output: Path | None = arguments.output
    if output is not None:
        with output.open("x", encoding="utf-8") as file:
            file.write(text)
        print_status(f"written: {output}")
    if arguments.json:
        print_json({"cell": arguments.cell, "file": None if output is None else str(output), "text": text})
    elif output is None:
        print(text, end="")
    return 0


def unit_of(cell: Path) -> str:
    """Return the unit that runs a cell, as this user and in this folder, with this Python.

    Raises
    ------
    CellFileError
        If the cell file is invalid.
    ArgumentError
        If a path has a line break.
    """
    from beltsort.cellfile.description import CellDescription
    from beltsort.cellfile.watchdog import longest_step

    description = CellDescription.load(cell)
    file, folder = str(cell.resolve()), str(Path.cwd())
    beltsort = [sys.executable, "-m", "beltsort"]
    template = (files("beltsort.cellfile") / "examples" / "beltsort.service").read_text("utf-8")
    return Template(template).substitute(
        cell=_escaped(file),
        user=getpass.getuser(),
        folder=_escaped(folder),
        command=_quoted(*beltsort, "run", file, "--live", "--service", "--allow-hold"),
        stop=_quoted(*beltsort, "stop", "latest", "--wait"),
        watchdog=math.ceil(longest_step(description)),
    )


def _escaped(text: str) -> str:
    """Return text in which systemd replaces nothing."""
    if "\n" in text:
        raise ArgumentError(f"{text!r} has a line break, which a unit cannot contain; rename it")
    return text.replace("%", "%%")


def _quoted(*words: str) -> str:
    """Return a command line in systemd's syntax."""
    return " ".join(map(_quoted_word, words))


def _quoted_word(word: str) -> str:
    text = _escaped(word).replace("$", "$$")
    if any(character in text for character in " \t'\"\\;"):
        text = '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'
    return text
