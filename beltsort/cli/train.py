"""`beltsort train`: a classifier from folders of clouds or meshes."""

from argparse import ArgumentParser, ArgumentTypeError, Namespace
from math import isfinite
from pathlib import Path
from typing import Any

from beltsort import ArgumentError
from beltsort.cli.arguments import Subparsers, add_json
from beltsort.cli.clouds import ORIGIN, add_viewpoint
from beltsort.cli.output import print_json, tell
from beltsort.cli.progress import tenths
from beltsort.perception.confusion import Confusion, confusion
from beltsort.perception.distances import DISTANCES
from beltsort.perception.leave_one_out import PERCENTILE, leave_one_out, rejection_threshold, with_rejection
from beltsort.perception.nearest import NearestNeighbour
from beltsort.perception.training import Trained, train_from_clouds
from beltsort.util.text import numbers_or_none

AUTOMATIC = "auto"
OBJECTS, SEED = 40, 0


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "train",
        help="train a classifier from folders of clouds or meshes",
        description="Train a nearest-neighbour classifier. Each sub-folder of FOLDER is a class and holds "
        "clouds of single objects (.pcd, .ply, .xyz, .npy; metres). The report is by leaving one out: every "
        "entry is classified by all others.",
    )
    parser.add_argument("folder", metavar="FOLDER", type=Path, help="one sub-folder for each class")
    parser.add_argument(
        "-o", "--output", metavar="DB", type=Path, required=True, help="where to write the database (.npz)"
    )
    add_viewpoint(parser)
    _add_meshes(parser)
    parser.add_argument("--distance", choices=list(DISTANCES), default="chi2", help="default: chi2")
    parser.add_argument("-k", type=int, default=1, metavar="N", help="neighbours that vote (default: 1)")
    parser.add_argument(
        "--reject",
        type=_rejection,
        metavar="DISTANCE",
        help=f"give no label beyond this distance; {AUTOMATIC}: the one within which {PERCENTILE:g} of 100 "
        "entries lie of another of their class (default: every cloud gets a label)",
    )
    parser.add_argument("--figure", metavar="PNG", type=Path, help="draw which class is taken for which")
    add_json(parser)
    parser.set_defaults(run=run)


def _add_meshes(parser: ArgumentParser) -> None:
    parser.add_argument(
        "--meshes",
        action="store_true",
        help="FOLDER holds meshes (PLY, STL, OBJ, OFF, glTF; metres, axis along z), which are scanned in the "
        "simulated cell; one outside of a sub-folder is a class of its own",
    )
    parser.add_argument(
        "--objects",
        type=int,
        metavar="N",
        help=f"with --meshes: objects per mesh, viewpoint and position (default: {OBJECTS})",
    )
    parser.add_argument(
        "--seed", type=int, metavar="N", help=f"with --meshes: of the scans (default: {SEED})"
    )


def _rejection(text: str) -> float | str:
    if text == AUTOMATIC:
        return text
    try:
        distance = float(text)
    except ValueError:
        distance = 0.0
    if not (isfinite(distance) and distance > 0.0):
        raise ArgumentTypeError(f"{text!r}: expected a finite distance above 0, or {AUTOMATIC}")
    return distance


def run(arguments: Namespace) -> int:
    """Train, report and save."""
    _check_arguments(arguments)
    trained = _trained(arguments)
    for skipped in trained.skipped:
        tell(f"skipped {skipped.path}: {skipped.reason}")
    left_out = leave_one_out(trained.database)
    suggested = rejection_threshold(trained.database, left_out)
    reject = _chosen(arguments.reject, suggested)
    database, answers = with_rejection(trained.database, left_out, reject)
    table = confusion(database.labels, answers, database.classes)
    database.save(arguments.output)
    if arguments.figure is not None:
        from beltsort.perception.confusion import draw_confusion

        draw_confusion(table, arguments.figure)
    if arguments.json:
        print_json(_as_json(arguments, trained, table, reject, suggested))
    else:
        _show_text(arguments, database, table, suggested)
    return 0


def _check_arguments(arguments: Namespace) -> None:
    """Refuse what can be refused before minutes are spent."""
    foreign = ("viewpoint",) if arguments.meshes else ("objects", "seed")
    for name in foreign:
        if getattr(arguments, name) is not None:
            where = "with" if arguments.meshes else "without"
            raise ArgumentError(f"--{name} means nothing {where} --meshes; leave it out")
    if arguments.figure is not None and arguments.figure.suffix != ".png":
        raise ArgumentError(f"{arguments.figure} does not end in .png, the one format that is drawn")
    for file in (arguments.output, arguments.figure):
        if file is not None and not file.parent.is_dir():
            raise ArgumentError(f"{file.parent} is no folder, so {file} cannot be written; make it first")


def _trained(arguments: Namespace) -> Trained:
    settings = {"distance": arguments.distance, "k": arguments.k}
    if not arguments.meshes:
        return train_from_clouds(arguments.folder, viewpoint=arguments.viewpoint or ORIGIN, **settings)
    from beltsort.sim.meshes import train_from_meshes

    return train_from_meshes(
        arguments.folder,
        objects=OBJECTS if arguments.objects is None else arguments.objects,
        seed=SEED if arguments.seed is None else arguments.seed,
        progress=tenths("scans"),
        **settings,
    )


def _chosen(reject: float | str | None, suggested: float | None) -> float | None:
    if not isinstance(reject, str):
        return reject
    if suggested is None:
        raise ArgumentError(
            f"--reject {reject}: no class has two different entries, expected some that show how far apart "
            "they lie; give more clouds, or a distance"
        )
    return suggested


def _as_json(
    arguments: Namespace, trained: Trained, table: Confusion, reject: float | None, suggested: float | None
) -> dict[str, Any]:
    return {
        "command_line": arguments.command_line,
        "database": str(arguments.output),
        "entries": table.total,
        "files": len(trained.files),
        "skipped": [{"file": str(s.path), "reason": s.reason} for s in trained.skipped],
        "distance": trained.database.distance,
        "k": trained.database.k,
        "reject": reject,
        "suggested_reject": suggested,
        "classes": list(table.classes),
        "confusion": table.counts.tolist(),
        "right": table.right,
        "recall": numbers_or_none(dict(zip(table.classes, table.recall.tolist(), strict=True))),
    }


def _show_text(
    arguments: Namespace, database: NearestNeighbour, table: Confusion, suggested: float | None
) -> None:
    share = 100.0 * table.right / table.total
    print(
        f"{arguments.output}: {table.total} entries of {len(table.classes)} classes, "
        f"distance {database.distance}, k = {database.k}"
    )
    print(f"Leaving one out, {table.right} of {table.total} are right ({share:.1f} %):")
    print(table)
    if database.reject is not None:
        print(f"Beyond distance {database.reject:g} there is no label.")
    elif suggested is not None:
        print(
            f"Every cloud gets a label. {PERCENTILE:g} of 100 entries lie within distance {suggested:g} of "
            f"another of their class: --reject {AUTOMATIC} gives no label beyond it."
        )
