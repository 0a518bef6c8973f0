"""`beltsort evaluate`: simulate a policy."""

from argparse import Namespace

from beltsort import ArgumentError, Evaluation
from beltsort import evaluate as simulate
from beltsort._core import DEFAULT_INFORMATION_POSITIONS
from beltsort.cli.arguments import (
    Subparsers,
    add_budget,
    add_json,
    add_model,
    add_simulation,
    load_model,
    simulation_of,
)
from beltsort.cli.output import print_json, print_table
from beltsort.planning.bins import SortingStatistics, sorting_statistics, sorts_into_classes
from beltsort.planning.named_policy import HELP, named_policy
from beltsort.util.text import numbers_or_none

BINS = """
Objects of each class in each bin per batch, purity (share of a bin's objects that belong there) and recovery
(share of the objects that belong there which arrived there):"""
OPTIONS_OF = {
    "despot": {"trials", "seconds"},
    "threshold": {"threshold"},
    "information-gain": {"threshold", "positions_counted"},
}

EXAMPLE = "beltsort evaluate paper --policy threshold:0.94 --batches 100"


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser = subparsers.add_parser("evaluate", help="simulate a policy and print its statistics")
    add_model(parser)
    parser.add_argument("--policy", required=True, metavar="POLICY", help=HELP)
    parser.add_argument(
        "--threshold",
        type=float,
        metavar="T",
        help="T of --policy threshold:T or information-gain:T",
    )
    parser.add_argument(
        "--positions-counted",
        type=int,
        metavar="N",
        help="positions over which information-gain sums information (default: "
        f"{DEFAULT_INFORMATION_POSITIONS})",
    )
    add_budget(parser)
    add_simulation(parser)
    add_json(parser)
    parser.set_defaults(run=run)


def run(arguments: Namespace) -> int:
    """Simulate and print."""
    model = load_model(arguments)
    result = simulate(model, named_policy(policy_word(arguments), model), **simulation_of(arguments, model))
    sorting = sorting_statistics(model, result)
    if arguments.json:
        show_json(arguments, result, sorting)
    else:
        show_text(arguments, result, None if sorts_into_classes(model) else sorting)
    return 0


def policy_word(arguments: Namespace) -> str:
    """Return the policy's name, in which the options that stand for its parameters are written out."""
    word: str = arguments.policy
    options = OPTIONS_OF.get(word, set())
    for option in sorted(set().union(*OPTIONS_OF.values()) - options):
        if getattr(arguments, option) is not None:
            raise ArgumentError(
                f"--{option.replace('_', '-')} means nothing to --policy {word}; leave it out"
            )
    if arguments.seconds is not None:
        return f"{word}:{arguments.seconds!r}s"
    if arguments.trials is not None:
        return f"{word}:{arguments.trials}"
    if "threshold" not in options:
        return word
    if arguments.threshold is None:
        raise ArgumentError(
            f"--policy {word} needs a threshold: write --policy {word}:0.94, or --threshold 0.94, for example"
        )
    counted = "" if arguments.positions_counted is None else f":{arguments.positions_counted}"
    return f"{word}:{arguments.threshold!r}{counted}"


def show_json(arguments: Namespace, result: Evaluation, sorting: SortingStatistics) -> None:
    """Print the statistics as one JSON object."""
    print_json(
        {
            "command_line": arguments.command_line,
            "policy": arguments.policy,
            "batches": arguments.batches,
            "batch_size": arguments.batch_size,
            "seed": arguments.seed,
            "summary": {name: numbers_or_none(statistics) for name, statistics in result.summary().items()},
            "sorting": sorting.to_dict(),
        }
    )


def show_text(arguments: Namespace, result: Evaluation, sorting: SortingStatistics | None) -> None:
    """Print the statistics as a table, and what arrived in the bins as another."""
    print(f"Per batch of {arguments.batch_size}, mean and standard error over {arguments.batches}:")
    print_table(
        [
            (name.replace("_", " "), f"{statistics['mean']:.3f}", f"± {statistics['standard_error']:.3f}")
            for name, statistics in result.summary().items()
        ]
    )
    if sorting is not None:
        print(f"  reward of decisions, without moves: {sorting.reward}\n{BINS}")
        print(sorting)
    print(f"Made by: {arguments.command_line}")
