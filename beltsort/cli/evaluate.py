"""`beltsort evaluate`: how well a policy sorts, by simulation."""

from argparse import Namespace

from beltsort import ArgumentError, Despot, Evaluation, InformationGain, Policy, SortingModel, Threshold
from beltsort import evaluate as simulate
from beltsort.cli.arguments import Subparsers, add_budget, add_json, add_model, budget_of, index_of
from beltsort.cli.output import number_or_none, print_json, print_table

OPTIONS_OF = {
    "despot": {"trials", "seconds"},
    "threshold": {"threshold"},
    "information-gain": {"threshold", "positions_counted"},
}


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser = subparsers.add_parser("evaluate", help="simulate a policy and print its statistics")
    add_model(parser)
    parser.add_argument("--policy", choices=OPTIONS_OF, required=True)
    parser.add_argument("--threshold", type=float, metavar="T", help="probability at which to decide")
    parser.add_argument(
        "--positions-counted",
        type=int,
        metavar="N",
        help="positions whose information counts (information-gain; default: 1)",
    )
    add_budget(parser)
    parser.add_argument("--batches", type=int, default=1000, metavar="N", help="default: 1000")
    parser.add_argument(
        "--batch-size", type=int, default=10, metavar="N", help="decisions per batch (default: 10)"
    )
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="of objects and labels (default: 0)")
    parser.add_argument("--threads", type=int, metavar="N", help="default: all cores")
    parser.add_argument(
        "--true-classes", metavar="A,B", help="draw objects uniformly from these classes (names or indices)"
    )
    add_json(parser)
    parser.set_defaults(run=run)


def run(arguments: Namespace) -> int:
    """Simulate and print."""
    model = SortingModel.load(arguments.model)
    result = simulate(
        model,
        make_policy(arguments, model),
        batches=arguments.batches,
        batch_size=arguments.batch_size,
        seed=arguments.seed,
        threads=arguments.threads,
        true_classes=parse_classes(arguments.true_classes, model),
    )
    show = show_json if arguments.json else show_text
    show(arguments, result)
    return 0


def make_policy(arguments: Namespace, model: SortingModel) -> Policy:
    """Make the policy that was named, and refuse options that it does not have."""
    every_option = set().union(*OPTIONS_OF.values())
    for option in sorted(every_option - OPTIONS_OF[arguments.policy]):
        if getattr(arguments, option) is not None:
            raise ArgumentError(
                f"--{option.replace('_', '-')} means nothing to --policy {arguments.policy}; leave it out"
            )
    if arguments.policy == "despot":
        return Despot(model, **budget_of(arguments))
    if arguments.threshold is None:
        raise ArgumentError(f"--policy {arguments.policy} needs --threshold, 0.94 for example")
    if arguments.policy == "threshold":
        return Threshold(model, arguments.threshold)
    counted = 1 if arguments.positions_counted is None else arguments.positions_counted
    return InformationGain(model, arguments.threshold, counted)


def parse_classes(text: str | None, model: SortingModel) -> list[int] | None:
    """Read names separated by commas."""
    if text is None:
        return None
    return [index_of(name, model.classes, "class") for name in text.split(",")]


def show_json(arguments: Namespace, result: Evaluation) -> None:
    """Print the statistics as one JSON object."""
    print_json(
        {
            "command_line": arguments.command_line,
            "policy": arguments.policy,
            "batches": arguments.batches,
            "batch_size": arguments.batch_size,
            "seed": arguments.seed,
            "summary": {
                name: {key: number_or_none(value) for key, value in statistics.items()}
                for name, statistics in result.summary().items()
            },
        }
    )


def show_text(arguments: Namespace, result: Evaluation) -> None:
    """Print the statistics as a table."""
    print(f"Per batch of {arguments.batch_size}, mean and standard error over {arguments.batches}:")
    print_table(
        [
            (name.replace("_", " "), f"{statistics['mean']:.3f}", f"± {statistics['standard_error']:.3f}")
            for name, statistics in result.summary().items()
        ]
    )
    print(f"Made by: {arguments.command_line}")
