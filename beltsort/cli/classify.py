"""`beltsort classify`: label point clouds."""

from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from beltsort.cli.arguments import Subparsers, add_camera_position, add_json
from beltsort.cli.exit_codes import DONE, EXCEEDED
from beltsort.cli.output import print_json, print_status, print_table
from beltsort.errors import CloudError
from beltsort.perception.cameras import CameraPositions
from beltsort.perception.classifier import Match
from beltsort.perception.kernel_ridge import TrainedClassifier, load_trained
from beltsort.perception.training import camera_positions, read_view
from beltsort.util.text import number_or_none

DISTANCES = ("distance", "runner_up_distance")

EXAMPLE = "beltsort classify bulbs.npz scan.pcd"


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "classify",
        help="label clouds with a trained classifier",
        description="Label point clouds, each of a single object; metres. Formats: .pcd, .ply, text (.xyz, "
        ".txt, .csv, .asc, .pts), .npy, and 16-bit depth images (.png) beside their intrinsics (see "
        "docs/files.md). Clouds that cannot be labelled are named on standard error, and the exit code is 1. "
        "A cloud that is farther from every training cloud than these are from each other is marked: it may "
        "be of another object, of several, or of a whole scene.",
    )
    parser.add_argument("database", metavar="DB", help="a classifier that `beltsort train` wrote")
    parser.add_argument("clouds", metavar="CLOUD", nargs="+", type=Path, help="a point cloud file")
    add_camera_position(parser)
    add_json(parser)
    parser.set_defaults(run=run)


def run(arguments: Namespace) -> int:
    """Label and print; a cloud that cannot be labelled keeps none of the others from it."""
    classifier = load_trained(arguments.database)
    positions = camera_positions(arguments.viewpoint)
    results, failed = [], []
    for cloud in arguments.clouds:
        try:
            match = _match(classifier, cloud, positions)
        except CloudError as reason:
            failed.append({"cloud": str(cloud), "reason": str(reason)})
        else:
            results.append({"cloud": str(cloud), **_as_json(match, classifier)})
    if not results:
        raise CloudError("; ".join(failure["reason"] for failure in failed))
    for failure in failed:
        print_status(f"not labelled: {failure['reason']}")
    if arguments.json:
        print_json({"command_line": arguments.command_line, "clouds": results, "failed": failed})
    else:
        print_table(table(results))
    return EXCEEDED if failed else DONE


def _match(classifier: TrainedClassifier, cloud: Path, positions: CameraPositions) -> Match:
    try:
        seen = read_view(cloud, classifier.config, positions)
        return classifier.classify(seen.points, seen.camera)
    except CloudError as reason:
        if str(cloud) in str(reason):
            raise
        raise CloudError(f"{cloud}: {reason}") from reason


def _as_json(match: Match, classifier: TrainedClassifier) -> dict[str, Any]:
    classes = classifier.classes
    best, *others = (classes[label] for label in match.ranking)
    measured = zip(DISTANCES, (match.distance, match.runner_up), strict=True)
    return {
        "label": None if match.label is None else best,
        "nearest": best,
        "runner_up": others[0] if others else None,
        **{name: None if value is None else number_or_none(value) for name, value in measured},
        "training_distance": classifier.training_distance,
        "beyond_training": classifier.beyond_training(match),
        "scores": dict(zip(classes, match.scores.tolist(), strict=True)),
    }


def table(results: Sequence[dict[str, Any]]) -> list[list[str]]:
    """Return a row for each cloud, with a column of notes if there is one."""
    rows = [["cloud", "label", "distance", "runner-up", "distance"], *map(_row, results)]
    notes = ["note", *map(_note, results)]
    return [[*row, note] for row, note in zip(rows, notes, strict=True)] if any(notes[1:]) else rows


def _row(result: dict[str, Any]) -> list[str]:
    label = result["label"] or f"none (nearest: {result['nearest']})"
    distances = ["-" if result[name] is None else f"{result[name]:.4g}" for name in DISTANCES]
    return [result["cloud"], label, distances[0], result["runner_up"] or "-", distances[1]]


def _note(result: dict[str, Any]) -> str:
    """Return a remark on a cloud that is unlike all training clouds; empty for others."""
    if not result["beyond_training"]:
        return ""
    return f"beyond the training distance: {result['distance']:.4g} > {result['training_distance']:.4g}"
