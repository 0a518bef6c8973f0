"""Arguments that several commands share."""

from argparse import ArgumentParser, Namespace, _SubParsersAction
from collections.abc import Sequence
from difflib import get_close_matches
from typing import Any, TypeAlias

from beltsort import ArgumentError, SortingModel

Subparsers: TypeAlias = "_SubParsersAction[ArgumentParser]"


DEFAULT_TRIALS = 300  # one or two milliseconds per plan on the paper's model


def add_json(parser: ArgumentParser) -> None:
    """Add `--json`, which every command has."""
    parser.add_argument("--json", action="store_true", help="print exactly one JSON object")


def add_model(parser: ArgumentParser) -> None:
    """Add the model file."""
    parser.add_argument("model", metavar="MODEL", help="a model file (JSON)")


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
    }


def parse_classes(text: str | None, model: SortingModel) -> list[int] | None:
    """Read names separated by commas."""
    if text is None:
        return None
    return [index_of(name, model.classes, "class") for name in text.split(",")]


def index_of(text: str, names: Sequence[str], what: str) -> int:
    """Find a name, or a number in its place.

    Parameters
    ----------
    text
        What the user wrote.
    names
        The names that there are.
    what
        What they name, for the message.

    Returns
    -------
    int
        Index into `names`.

    Raises
    ------
    ArgumentError
        Listing the names, the nearest one first, if `text` is none of them and no index either.
    """
    if text in names:
        return names.index(text)
    if text.isdecimal() and int(text) < len(names):
        return int(text)
    nearest = get_close_matches(text, names, n=1, cutoff=0.0)
    raise ArgumentError(
        f"there is no {what} {text!r}; did you mean {nearest[0]!r}? "
        f"Known: {', '.join(names)}, or 0 to {len(names) - 1}"
    )
