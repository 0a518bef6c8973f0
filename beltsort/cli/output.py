"""What the commands print."""

import json
import shlex
import sys
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from beltsort import Decide, Move, SortingModel
from beltsort.util.text import text_table

if TYPE_CHECKING:
    from rich.console import Console

    from beltsort.cellfile.composed import ComposedCell
    from beltsort.cellfile.composed_moving import ComposedMovingCell
    from beltsort.cellfile.description import CellDescription


MOST_WARNINGS = 20


def print_json(result: Mapping[str, Any]) -> None:
    """Print one JSON object."""
    print(json.dumps(result, indent=2, allow_nan=False))


def print_status(line: str) -> None:
    """Print a line that is not part of the result, on standard error."""
    print(line, file=sys.stderr)


@contextmanager
def warnings_on_lines() -> Iterator[None]:
    """Print the first warnings as lines of their own, without the place in the code, and count the others."""
    given = 0

    def show(message: Warning | str, *_: object, **__: object) -> None:
        nonlocal given
        given += 1
        if given <= MOST_WARNINGS:
            print_status(f"beltsort: warning: {' '.join(str(message).split())}")

    with warnings.catch_warnings():
        warnings.showwarning = show
        try:
            yield
        finally:
            if given > MOST_WARNINGS:
                print_status(f"beltsort: and {given - MOST_WARNINGS} more warnings")


def print_recording(path: Path | None) -> None:
    """Print how to look at a recording, if there is one."""
    if path is not None:
        print_status(f"recording: {path}; to look at it: {shlex.join(['rerun', str(path)])}")


def print_table(rows: Sequence[Sequence[str]]) -> None:
    """Print rows in columns, the first column left-aligned."""
    print(text_table(rows))


def print_cell_mode(
    console: "Console", description: "CellDescription", cell: "ComposedCell | ComposedMovingCell"
) -> None:
    """Print whether faults are injected, and which devices are in a dry run."""
    if description.faults is not None:
        console.print(
            "faults are injected on purpose; remove [faults] from the cell file to disable this", markup=False
        )
    if cell.dry_run:
        devices = ", ".join(cell.dry_run)
        console.print(
            f"dry run: {devices} do not move, their commands are only printed; --live sends them",
            markup=False,
        )


def action_as_json(model: SortingModel, action: Move | Decide) -> dict[str, str]:
    """Return an action as a dictionary of its kind and the name of its viewpoint or bin."""
    match action:
        case Move(viewpoint):
            return {"move": model.viewpoints[viewpoint]}
        case Decide(index):
            return {"decide": model.bins[index]}
