"""`beltsort check`: compare a cell with its cell file."""

from argparse import Namespace
from typing import TYPE_CHECKING, Any

from beltsort import BeltsortError, SortingModel
from beltsort.cli.arguments import Subparsers, add_cell, add_json
from beltsort.cli.exit_codes import EXCEEDED
from beltsort.cli.output import print_cell_mode, print_json, print_status, print_table
from beltsort.util.text import position_number

if TYPE_CHECKING:
    from beltsort.cell.wrappers.recorder import Recorded
    from beltsort.cellfile.check import CellCheck, View
    from beltsort.cellfile.composed import ComposedCell
    from beltsort.cellfile.composed_moving import ComposedMovingCell
    from beltsort.cellfile.description import CellDescription

EXAMPLE = "beltsort check cell.toml"


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "check",
        help="visit every viewpoint of a cell and compare the scans with its cell file",
        description="Query the health of every device, visit every viewpoint, take a scan at each, and print "
        "where the belt is, how much of every position is seen and what is found there, the duration of "
        "each call, and what the model promises. The exit code is 1 if a limit of the file's table [check] "
        "is exceeded, the belt is not where a camera's pose says, or the classifier does not fit the file.",
    )
    add_cell(parser)
    add_json(parser)
    parser.set_defaults(run=run)


def run(arguments: Namespace) -> int:
    """Run the command."""
    from rich.console import Console

    from beltsort.cellfile.bins import with_bins_of
    from beltsort.cellfile.check import check_cell
    from beltsort.cellfile.composed import compose
    from beltsort.cellfile.composed_moving import compose_moving
    from beltsort.cellfile.description import CellDescription
    from beltsort.planning.expectation import expectation
    from beltsort.sorting.locks import devices_locked

    console = Console(stderr=True, highlight=False, markup=False, soft_wrap=True)
    description = CellDescription.load(arguments.cell)
    model = model_of(description)
    if model is not None:
        description = with_bins_of(model, description)
    calls: list[Recorded] = []
    devices: list[object] = []
    composed = compose if description.moving is None else compose_moving
    cell = composed(
        description,
        live=arguments.live,
        say=console.print,
        record=calls.append,
        made=devices.append,
    )
    print_cell_mode(console, description, cell)
    with devices_locked(devices):
        found = check_cell(cell, description.check)
    found.exceeded += classifier_problems(description)
    expected = None if model is None else expectation(model, max_looks=description.rules.max_looks)
    if arguments.json:
        promised = None if expected is None else expected.to_dict()
        limits = description.check.model_dump()
        print_json({**as_json(cell, found, calls), "limits": limits, "expected": promised})
    else:
        show(found, calls)
        listed = ", ".join(f"{name} {limit:g}" for name, limit in description.check)
        print(f"limits (the file's [check]): {listed}")
        if expected is not None:
            print(f"\nmodel {description.model}:\n{expected}")
    return EXCEEDED if found.exceeded else 0


def classifier_problems(description: "CellDescription") -> list[str]:
    """Return why a run could not use the cell file's classifier; nothing if it could, or prepares its own."""
    from beltsort.cellfile.ingredients import classifier_of

    if description.classifier is None:
        return []
    try:
        classifier_of(description)
    except BeltsortError as reason:
        return [str(reason)]
    return []


def model_of(description: "CellDescription") -> SortingModel | None:
    """Return the cell file's model; None without a model file, or if it cannot be read."""
    if description.model is None:
        return None
    try:
        return SortingModel.load(description.path(description.model))
    except BeltsortError as reason:
        print_status(f"Warning: {reason}.")
        return None


def as_json(
    cell: "ComposedCell | ComposedMovingCell", found: "CellCheck", calls: "list[Recorded]"
) -> dict[str, Any]:
    """Return the results of the check as plain data."""
    from dataclasses import asdict

    return {
        "dry_run": list(cell.dry_run),
        "health": {role: asdict(health) for role, health in found.health.items()},
        "viewpoints": [asdict(view) for view in found.views],
        "seconds": [
            {"act": name, "calls": n, "mean": mean, "most": most} for name, n, mean, most in times(calls)
        ],
        "exceeded": found.exceeded,
    }


def show(found: "CellCheck", calls: "list[Recorded]") -> None:
    """Print the results of the check."""
    health = [(role, "yes" if each.ready else "no", each.boot_id) for role, each in found.health.items()]
    print_table([("device", "ready", "boot id"), *health])
    if found.views:
        print()
        seen = ("belt angle", "belt height", "belt points", "position", "in image", "points", "finding")
        views = (row for view in found.views for row in view_rows(view))
        print_table([("viewpoint", "pose off by", *seen), *views])
    print()
    rows = [(name, str(n), f"{mean:.3f} s", f"{most:.3f} s") for name, n, mean, most in times(calls)]
    print_table([("call", "number", "mean", "longest"), *rows])
    print()
    for line in found.exceeded or ["everything is within the limits"]:
        print(line)


def view_rows(view: "View") -> list[tuple[str, ...]]:
    """Return a row for each position seen from a viewpoint."""
    off = "?" if view.pose is None else f"{view.pose.angle:.2f} deg, {view.pose.distance:.1f} mm"
    belt = (off, f"{view.belt.angle:.2f} deg", f"{view.belt.height:+.1f} mm", str(view.belt.points))
    return [
        (
            *((view.viewpoint, *belt) if position == 0 else [""] * 5),
            position_number(position),
            "?" if crop.inside is None else f"{crop.inside:.0%}",
            str(crop.points),
            view.findings[position] if view.findings else "?",
        )
        for position, crop in enumerate(view.crops)
    ]


def times(calls: "list[Recorded]") -> list[tuple[str, int, float, float]]:
    """Return name, number, mean and longest duration (seconds) of each kind of call."""
    seconds: dict[str, list[float]] = {}
    for recorded in calls:
        seconds.setdefault(recorded.call.name, []).append(recorded.seconds)
    return [(name, len(each), sum(each) / len(each), max(each)) for name, each in seconds.items()]
