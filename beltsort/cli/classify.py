"""`beltsort classify`: label point clouds."""

from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from beltsort.cli.arguments import ORIGIN, Subparsers, add_camera_position, add_json
from beltsort.cli.output import print_json, print_table
from beltsort.errors import CloudError
from beltsort.geometry import Points
from beltsort.perception.classifier import Match
from beltsort.perception.nearest import NearestNeighbour
from beltsort.perception.training import read_candidate
from beltsort.util.text import number_or_none

DISTANCES = ("distance", "runner_up_distance")


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "classify",
        help="label clouds with a trained classifier",
        description="Label point clouds, each of a single object (.pcd, .ply, .xyz, .npy; metres). A cloud "
        "that is farther from every training cloud than these are from each other is marked: it may be of "
        "another object, of several, or of a whole scene.",
    )
    parser.add_argument("database", metavar="DB", help="a classifier that `beltsort train` wrote")
    parser.add_argument("clouds", metavar="CLOUD", nargs="+", type=Path, help="a point cloud file")
    add_camera_position(parser)
    add_json(parser)
    parser.set_defaults(run=run)


def run(arguments: Namespace) -> int:
    """Label and print."""
    database = NearestNeighbour.load(arguments.database)
    camera = np.array(arguments.viewpoint or ORIGIN)
    results = [
        {"cloud": str(cloud), **_as_json(_match(database, cloud, camera), database)}
        for cloud in arguments.clouds
    ]
    if arguments.json:
        print_json({"command_line": arguments.command_line, "clouds": results})
    else:
        print_table(table(results))
    return 0


def _match(database: NearestNeighbour, cloud: Path, camera: Points) -> Match:
    try:
        return database.classify(read_candidate(cloud, database.config), camera)
    except CloudError as reason:
        raise CloudError(f"{cloud}: {reason}") from reason


def _as_json(match: Match, database: NearestNeighbour) -> dict[str, Any]:
    classes = database.classes
    best, *others = (classes[label] for label in match.ranking)
    measured = zip(DISTANCES, (match.distance, match.runner_up), strict=True)
    return {
        "label": None if match.label is None else best,
        "nearest": best,
        "runner_up": others[0] if others else None,
        **{name: None if value is None else number_or_none(value) for name, value in measured},
        "training_distance": database.training_distance,
        "beyond_training": database.beyond_training(match),
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
