"""`beltsort train`: train a classifier on folders of point clouds or meshes."""

from argparse import ArgumentTypeError, Namespace
from math import isfinite
from pathlib import Path
from typing import Any, get_args

from beltsort import ArgumentError
from beltsort.cli.arguments import Subparsers, add_camera_position, add_json, check_writable
from beltsort.cli.output import print_json, print_status
from beltsort.cli.progress import tenths
from beltsort.perception.config import Descriptor, PerceptionConfig
from beltsort.perception.confusion import Confusion, confusion
from beltsort.perception.distances import DISTANCES
from beltsort.perception.kernel_ridge import KernelRidge, TrainedClassifier
from beltsort.perception.leave_one_out import (
    PERCENTILE,
    Suspect,
    leave_one_out,
    rejection_threshold,
    suspects,
    with_rejection,
)
from beltsort.perception.nearest import NearestNeighbour
from beltsort.perception.training import Trained, train_from_clouds
from beltsort.sim.config import TRAINING_OBJECTS
from beltsort.util.extras import require
from beltsort.util.text import numbers_or_none

AUTOMATIC = "auto"
NEAREST, KERNEL_RIDGE = "nearest", "kernel-ridge"
SEED = 0
MOST_SUSPECTS = 10
"""Suspects that are listed; the others are counted."""

EXAMPLE = "beltsort train clouds/ -o bulbs.npz"


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "train",
        help="train a classifier on folders of point clouds or meshes",
        description="Train a classifier. Each sub-folder of FOLDER is a class and contains "
        "point clouds of single objects; metres. Formats: .pcd, .ply, text (.xyz, .txt, .csv, .asc, .pts), "
        ".npy, and 16-bit depth images (.png) beside their intrinsics (see docs/files.md). Prints the "
        "confusion matrix of leave-one-out cross-validation, and clouds that are nearest to another class.",
    )
    parser.add_argument("folder", metavar="FOLDER", type=Path, help="one sub-folder for each class")
    parser.add_argument(
        "-o", "--output", metavar="DB", type=Path, required=True, help="where to write the database (.npz)"
    )
    add_camera_position(parser)
    parser.add_argument(
        "--meshes",
        action="store_true",
        help="FOLDER contains meshes (PLY, STL, OBJ, OFF, glTF; metres, axis along z), which are scanned in "
        "the simulated cell; a mesh outside of a sub-folder is a class of its own",
    )
    parser.add_argument(
        "--objects",
        type=int,
        metavar="N",
        help=f"with --meshes: objects per mesh, viewpoint and position (default: {TRAINING_OBJECTS})",
    )
    parser.add_argument(
        "--seed", type=int, metavar="N", help=f"with --meshes: seed of the scans (default: {SEED})"
    )
    parser.add_argument(
        "--descriptor",
        choices=get_args(Descriptor),
        default="vfh",
        help="vfh: the viewpoint feature histogram; vfh+size: also the object's height above the belt and "
        "its horizontal extents, which needs clouds in the belt frame, z up, 0 on the belt (default: vfh)",
    )
    parser.add_argument(
        "--classifier",
        choices=[NEAREST, KERNEL_RIDGE],
        default=NEAREST,
        help=f"{NEAREST}: the nearest neighbours vote; {KERNEL_RIDGE}: kernel ridge regression on the "
        f"distances, which gives probabilities (default: {NEAREST})",
    )
    parser.add_argument(
        "--distance",
        choices=list(DISTANCES),
        default="chi2",
        help="distance between descriptors (default: chi2)",
    )
    parser.add_argument("-k", type=int, default=1, metavar="N", help="neighbours that vote (default: 1)")
    parser.add_argument(
        "--reject",
        type=_rejection,
        metavar="DISTANCE",
        help=f"give no label if the nearest entry is farther than this; {AUTOMATIC}: the {PERCENTILE:g}th "
        "percentile of the distances between nearest entries of the same class (default: no rejection)",
    )
    parser.add_argument("--figure", metavar="PNG", type=Path, help="draw the confusion matrix")
    add_json(parser)
    parser.set_defaults(run=run)


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
        print_status(str(skipped))
    if trained.own_viewpoints:
        print_status(
            f"{trained.own_viewpoints} of {len(trained.files)} files have a VIEWPOINT, which is the camera's "
            "position; if their points are in the camera frame, give --viewpoint 0,0,0"
        )
    left_out = leave_one_out(trained.database)
    suggested = rejection_threshold(trained.database, left_out)
    reject = _rejection_distance(arguments.reject, suggested)
    database, predicted = with_rejection(trained.database, left_out, reject)
    classifier: TrainedClassifier = database
    if arguments.classifier == KERNEL_RIDGE:
        classifier = KernelRidge.train(database)
        predicted = leave_one_out(classifier)
    # The scans of a mesh are of its class whatever they look like.
    doubtful = [] if arguments.meshes else suspects(database, left_out)
    table = confusion(database.labels, predicted, database.classes)
    classifier.save(arguments.output)
    if arguments.figure is not None:
        from beltsort.perception.confusion import draw_confusion

        draw_confusion(table, arguments.figure)
    if arguments.json:
        print_json(_as_json(arguments, trained, table, reject, suggested, doubtful))
    else:
        _show_text(arguments, database, trained, table, suggested)
        if doubtful:
            print(_suspects_text(trained, doubtful))
    return 0


def _check_arguments(arguments: Namespace) -> None:
    """Check the arguments before minutes are spent on training."""
    inapplicable = ("viewpoint",) if arguments.meshes else ("objects", "seed")
    for name in inapplicable:
        if getattr(arguments, name) is not None:
            where = "with" if arguments.meshes else "without"
            raise ArgumentError(f"--{name} does not apply {where} --meshes; leave it out")
    if arguments.classifier == KERNEL_RIDGE and arguments.k != 1:
        raise ArgumentError(
            f"-k {arguments.k} does not apply with --classifier {KERNEL_RIDGE}, which weighs all entries; "
            "leave it out"
        )
    if arguments.figure is not None:
        require("plot", "matplotlib")
    if arguments.figure is not None and arguments.figure.suffix != ".png":
        raise ArgumentError(
            f"--figure is {arguments.figure}, expected a name that ends in .png, the only format; rename it"
        )
    for file in (arguments.output, arguments.figure):
        if file is not None:
            check_writable(file)


def _trained(arguments: Namespace) -> Trained:
    settings = {"distance": arguments.distance, "k": arguments.k}
    config = PerceptionConfig(descriptor=arguments.descriptor)
    if not arguments.meshes:
        return train_from_clouds(arguments.folder, config, viewpoint=arguments.viewpoint, **settings)
    from beltsort.sim.meshes import train_from_meshes

    return train_from_meshes(
        arguments.folder,
        config,
        objects=TRAINING_OBJECTS if arguments.objects is None else arguments.objects,
        seed=SEED if arguments.seed is None else arguments.seed,
        progress=tenths("scans"),
        **settings,
    )


def _rejection_distance(reject: float | str | None, suggested: float | None) -> float | None:
    """Return the distance of `--reject`, with `auto` replaced by the suggested one."""
    if not isinstance(reject, str):
        return reject
    if suggested is None:
        raise ArgumentError(
            f"--reject {reject}: no class has two different entries, expected at least one class with two, "
            "to measure their distance; give more clouds, or a distance"
        )
    return suggested


def _as_json(
    arguments: Namespace,
    trained: Trained,
    table: Confusion,
    reject: float | None,
    suggested: float | None,
    doubtful: list[Suspect],
) -> dict[str, Any]:
    return {
        "command_line": arguments.command_line,
        "database": str(arguments.output),
        "entries": table.total,
        "files": len(trained.files),
        "missed": dict(trained.missed),
        "skipped": [{"file": str(s.path), "reason": s.reason} for s in trained.skipped],
        "descriptor": trained.database.config.descriptor,
        "classifier": arguments.classifier,
        "distance": trained.database.distance,
        "k": trained.database.k,
        "reject": reject,
        "suggested_reject": suggested,
        "classes": list(table.classes),
        "confusion": table.counts.tolist(),
        "right": table.right,
        "suspects": [
            {
                "file": str(trained.files[suspect.entry]),
                "class": trained.database.classes[trained.database.labels[suspect.entry]],
                "nearest": trained.database.classes[suspect.other],
                "distance": suspect.distance,
                "own_distance": suspect.own_distance,
            }
            for suspect in doubtful
        ],
        "recall": numbers_or_none(dict(zip(table.classes, table.recall.tolist(), strict=True))),
    }


def _show_text(
    arguments: Namespace,
    database: NearestNeighbour,
    trained: Trained,
    table: Confusion,
    suggested: float | None,
) -> None:
    share = 100.0 * table.right / table.total
    rule = f"k = {database.k}" if arguments.classifier == NEAREST else "kernel ridge regression"
    descriptor = "" if arguments.descriptor == "vfh" else f"descriptor {arguments.descriptor}, "
    print(
        f"{arguments.output}: {table.total} entries of {len(table.classes)} classes, {descriptor}"
        f"distance {database.distance}, {rule}"
    )
    print(_used_text(trained, "meshes" if arguments.meshes else "files"))
    print(f"Leave-one-out: {table.right} of {table.total} are right ({share:.1f} %):")
    print(table)
    if database.reject is not None:
        print(f"Clouds farther than {database.reject:g} from every entry get no label.")
    elif suggested is not None:
        print(
            f"Every cloud gets a label. The {PERCENTILE:g}th percentile of the distance to the nearest entry "
            f"of the same class is {suggested:g}; --reject {AUTOMATIC} gives no label beyond it."
        )


def _used_text(trained: Trained, what: str) -> str:
    """Return a sentence on how many files, and how many scans of meshes, were trained on."""
    used, skipped = len(trained.files), len(trained.skipped)
    files = f"all {used} {what}"
    if skipped:
        files = f"{used} {what}; {skipped} file{'' if skipped == 1 else 's'} skipped, see above"
    if not trained.missed:
        return f"Trained on {files}."
    entries, missed = len(trained.database.labels), sum(trained.missed.values())
    found = ", ".join(f"{finding} ({number})" for finding, number in sorted(trained.missed.items()))
    return (
        f"Trained on {files}: {entries} of {entries + missed} scans of objects. Found in the others: {found}."
    )


def _suspects_text(trained: Trained, doubtful: list[Suspect]) -> str:
    """Return a list of the entries that are nearest to another class."""
    database = trained.database
    lines = [
        f"{len(doubtful)} of {len(trained.files)} clouds are nearest to another class; check their folders:"
    ]
    for suspect in doubtful[:MOST_SUSPECTS]:
        own = database.classes[database.labels[suspect.entry]]
        lines.append(
            f"  {trained.files[suspect.entry]}: {suspect.distance:.4g} to {database.classes[suspect.other]}, "
            f"{suspect.own_distance:.4g} to {own}"
        )
    if len(doubtful) > MOST_SUSPECTS:
        lines.append(f"  and {len(doubtful) - MOST_SUSPECTS} more")
    return "\n".join(lines)
