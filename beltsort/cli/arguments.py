"""Arguments that several commands share."""

import json
from argparse import ArgumentParser, Namespace, _SubParsersAction
from inspect import signature
from typing import Any, TypeAlias

from beltsort import ArgumentError, Solution, SortingModel
from beltsort.planning.named_policy import DEFAULT_TRIALS
from beltsort.util.naming import index_of, nearest_of

Subparsers: TypeAlias = "_SubParsersAction[ArgumentParser]"


def add_json(parser: ArgumentParser) -> None:
    """Add `--json`, which every command has."""
    parser.add_argument("--json", action="store_true", help="print exactly one JSON object")


def add_model(parser: ArgumentParser) -> None:
    """Add the model file, and what is changed about it."""
    parser.add_argument("model", metavar="MODEL", help="a model file (JSON)")
    parser.add_argument("--positions", type=int, metavar="H", help="keep the first H positions only")
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="change a key of the model (--set r_min=500); repeat for further ones",
    )


def load_model(arguments: Namespace) -> SortingModel:
    """Read the model file and change what was asked for.

    Raises
    ------
    ArgumentError
        For a change that is not KEY=VALUE, or of a key that models do not have, naming the nearest one.
    """
    model = SortingModel.load(arguments.model)
    if arguments.positions is not None:
        model = model.with_positions(arguments.positions)
    changes = dict(parse_change(change) for change in arguments.set)
    return model.replace(**changes) if changes else model


def parse_change(text: str) -> tuple[str, Any]:
    """Read KEY=VALUE, the value as JSON, or as text if it is none."""
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
    """Add the two ways to say how long one plan may take."""
    budget = parser.add_mutually_exclusive_group()
    budget.add_argument(
        "--trials", type=int, metavar="N", help=f"trials per plan: reproducible (default: {DEFAULT_TRIALS})"
    )
    budget.add_argument("--seconds", type=float, metavar="S", help="seconds per plan")


def budget_of(arguments: Namespace) -> dict[str, Any]:
    """Return the budget that was given, as keywords of `Despot` and `Despot.plan`."""
    if arguments.seconds is not None:
        return {"seconds": arguments.seconds}
    return {"trials": DEFAULT_TRIALS if arguments.trials is None else arguments.trials}


def add_simulation(parser: ArgumentParser) -> None:
    """Add what is simulated: batches, objects and threads."""
    parser.add_argument("--batches", type=int, default=1000, metavar="N", help="default: 1000")
    parser.add_argument(
        "--batch-size", type=int, default=10, metavar="N", help="decisions per batch (default: 10)"
    )
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="of objects and labels (default: 0)")
    parser.add_argument("--threads", type=int, metavar="N", help="default: all cores")
    parser.add_argument(
        "--reference",
        metavar="FILE",
        help="a solution (`beltsort solve -o`) to measure regret against",
    )
    parser.add_argument(
        "--belt-ends",
        action="store_true",
        help="the belt ends with the batch, and planners know how many objects are left",
    )
    parser.add_argument(
        "--true-classes", metavar="A,B", help="draw objects uniformly from these classes (names or indices)"
    )


def simulation_of(arguments: Namespace, model: SortingModel) -> dict[str, Any]:
    """Return what is simulated, as keywords of `evaluate` and `compare`."""
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
    """Read names separated by commas."""
    if text is None:
        return None
    return [index_of(name, model.classes, "class") for name in text.split(",")]
