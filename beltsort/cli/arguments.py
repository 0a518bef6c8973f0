"""Arguments that several commands share."""

import json
import os
from argparse import ArgumentParser, ArgumentTypeError, Namespace, _SubParsersAction
from inspect import signature
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from beltsort import ArgumentError, Solution, SortingModel, models
from beltsort._core import DEFAULT_BATCH_SIZE, DEFAULT_BATCHES
from beltsort.errors import CloudError
from beltsort.planning.named_policy import DEFAULT_TRIALS
from beltsort.util.naming import index_of, nearest_of, split_names

if TYPE_CHECKING:
    from beltsort.perception.cameras import CameraPositions

Subparsers: TypeAlias = "_SubParsersAction[ArgumentParser]"


def add_json(parser: ArgumentParser) -> None:
    """Add `--json`, which every command has."""
    parser.add_argument("--json", action="store_true", help="print exactly one JSON object")


def add_whole_tree(parser: ArgumentParser) -> None:
    """Add `--whole-tree`."""
    parser.add_argument(
        "--whole-tree",
        action="store_true",
        help="with --json, print the searched tree with all actions and branches (default: the values of "
        "all actions, and what is likely to follow the chosen one)",
    )


MODEL_HELP = f"a model file (JSON), or the name of a packaged model: {', '.join(models.PACKAGED)}"


def add_model(parser: ArgumentParser, text: str = MODEL_HELP) -> None:
    """Add the model file, with a help text, and the options that modify the model."""
    parser.add_argument("model", metavar="MODEL", help=text)
    parser.add_argument("--positions", type=int, metavar="H", help="keep the first H positions only")
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="change a key of the model (--set r_min=500); may be repeated",
    )


def load_model(arguments: Namespace) -> SortingModel:
    """Read the model file and apply `--positions` and `--set`.

    Raises
    ------
    ArgumentError
        If a change is not KEY=VALUE, or the key does not exist; the message names the nearest key.
    """
    model = models.load(arguments.model)
    if arguments.positions is not None:
        model = model.with_positions(arguments.positions)
    changes = dict(parse_change(change) for change in arguments.set)
    return model.replace(**changes) if changes else model


def parse_change(text: str) -> tuple[str, Any]:
    """Parse KEY=VALUE; a value that is not valid JSON is kept as text."""
    key, equals, value = text.partition("=")
    if not equals:
        raise ArgumentError(f"--set {text}: expected KEY=VALUE, r_min=500 for example")
    known = list(signature(SortingModel).parameters)
    if key not in known:
        raise ArgumentError(f"--set {text}: a model has no key {key!r}; {nearest_of(key, known)}")
    try:
        return key, json.loads(value)
    except json.JSONDecodeError:
        return key, value


def add_budget(parser: ArgumentParser) -> None:
    """Add the budget of a plan, in trials or seconds."""
    budget = parser.add_mutually_exclusive_group()
    budget.add_argument(
        "--trials", type=int, metavar="N", help=f"trials per plan, reproducible (default: {DEFAULT_TRIALS})"
    )
    budget.add_argument("--seconds", type=float, metavar="S", help="seconds per plan")


def budget_of(arguments: Namespace) -> dict[str, Any]:
    """Return the budget as keyword arguments of `Despot` and `Despot.plan`."""
    if arguments.seconds is not None:
        return {"seconds": arguments.seconds}
    return {"trials": DEFAULT_TRIALS if arguments.trials is None else arguments.trials}


def add_simulation(parser: ArgumentParser) -> None:
    """Add the options of a simulation: batches, objects and threads."""
    parser.add_argument(
        "--batches",
        type=int,
        default=DEFAULT_BATCHES,
        metavar="N",
        help="batches to simulate (default: %(default)s)",
    )
    parser.add_argument(
        "--batch-size",
        type=int,
        default=DEFAULT_BATCH_SIZE,
        metavar="N",
        help="decisions per batch (default: %(default)s)",
    )
    parser.add_argument(
        "--seed", type=int, default=0, metavar="N", help="seed of objects and labels (default: 0)"
    )
    parser.add_argument("--threads", type=int, metavar="N", help="threads (default: all cores)")
    parser.add_argument(
        "--reference",
        metavar="FILE",
        help="a solution (`beltsort solve -o`) with which to compute regret, for one or two positions; "
        "`beltsort compare` also bounds what each policy loses, for any number",
    )
    parser.add_argument(
        "--belt-ends",
        action="store_true",
        help="the belt ends with the batch, and the belief includes the number of objects left",
    )
    parser.add_argument(
        "--true-classes", metavar="A,B", help="draw objects uniformly from these classes (names or indices)"
    )


def simulation_of(arguments: Namespace, model: SortingModel) -> dict[str, Any]:
    """Return the options of a simulation as keyword arguments of `evaluate` and `compare`."""
    return {
        "batches": arguments.batches,
        "batch_size": arguments.batch_size,
        "seed": arguments.seed,
        "threads": arguments.threads,
        "true_classes": parse_classes(arguments.true_classes, model),
        "belt_ends": arguments.belt_ends,
        "reference": None if arguments.reference is None else Solution.load(arguments.reference, model),
    }


def parse_classes(text: str | None, model: SortingModel) -> list[int] | None:
    """Parse class names or indices separated by commas."""
    if text is None:
        return None
    return [index_of(name, model.classes, "class") for name in split_names(text, model.classes)]


def add_cell(parser: ArgumentParser) -> None:
    """Add the cell file and `--live`."""
    parser.add_argument("cell", metavar="CELL.toml", help="a cell file: see docs/cell.md")
    parser.add_argument(
        "--live",
        action="store_true",
        help="send commands to the devices; without it, commands that would move hardware are only printed",
    )


def add_camera_position(parser: ArgumentParser) -> None:
    """Add `--viewpoint`, the position of the camera that recorded point clouds."""
    parser.add_argument(
        "--viewpoint",
        type=camera_positions,
        metavar="X,Y,Z|FILE",
        help="position of the camera in the frame of every cloud, metres, or a text file with a line "
        "PATH,X,Y,Z for each cloud (default: the VIEWPOINT of a PCD file, otherwise the origin). If X "
        "is negative, write --viewpoint=X,Y,Z",
    )


def camera_positions(text: str) -> "CameraPositions":
    """Parse the camera's position, or read a file of positions."""
    from beltsort.perception.cameras import CameraPositions, read_camera_positions

    if Path(text).is_file():
        try:
            return read_camera_positions(text)
        except CloudError as reason:
            raise ArgumentTypeError(str(reason)) from reason
    return CameraPositions(np.array(position(text)))


def position(text: str) -> tuple[float, ...]:
    """Parse three numbers separated by commas."""
    try:
        numbers = tuple(float(word) for word in text.split(","))
    except ValueError:
        numbers = ()
    if len(numbers) != 3 or not all(map(isfinite, numbers)):
        raise ArgumentTypeError(f"{text!r}: expected three finite numbers X,Y,Z, such as 0,0,0.7, or a file")
    return numbers


def check_writable(path: Path) -> None:
    """Raise an `ArgumentError` if a file cannot be written, before time is spent on its contents."""
    if path.is_dir():
        raise ArgumentError(f"{path} is a directory; name a file")
    if not path.parent.is_dir():
        raise ArgumentError(f"{path}: there is no directory {path.parent}; make it first")
    if not os.access(path.parent, os.W_OK):
        raise ArgumentError(f"{path}: the directory {path.parent} cannot be written to; name another")


def add_rrd(parser: ArgumentParser) -> None:
    """Add `--rrd`."""
    parser.add_argument(
        "--rrd",
        type=Path,
        metavar="FILE",
        help="record clouds, beliefs, values and decisions in a file for the rerun viewer (extra `rerun`)",
    )
