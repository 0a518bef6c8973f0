"""`beltsort compare`: compare policies on the same objects."""

from argparse import Namespace

from beltsort import ArgumentError
from beltsort import compare as simulate
from beltsort.cli.arguments import Subparsers, add_json, add_model, add_simulation, load_model, simulation_of
from beltsort.cli.output import print_json
from beltsort.cli.progress import terminal_progress
from beltsort.planning.named_policy import HELP, named_policy

EXAMPLE = "beltsort compare paper --policies despot:100 threshold:0.94 one-object --batches 100"


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "compare",
        help="simulate policies on the same objects and print their differences",
        description="Simulate policies on the same objects. Differences are paired by batch.",
    )
    add_model(parser)
    parser.add_argument("--policies", nargs="+", required=True, metavar="POLICY", help=HELP)
    parser.add_argument(
        "--baseline", metavar="POLICY", help="policy that the others are compared with (default: the first)"
    )
    add_simulation(parser)
    add_json(parser)
    parser.set_defaults(run=run)


def run(arguments: Namespace) -> int:
    """Simulate and print."""
    model = load_model(arguments)
    names: list[str] = arguments.policies
    if len(set(names)) < len(names):
        raise ArgumentError(f"--policies {' '.join(names)} names a policy twice; name each once")
    policies = {name: named_policy(name, model) for name in names}
    settings = simulation_of(arguments, model)
    with terminal_progress("policies") as progress:
        comparison = simulate(model, policies, baseline=arguments.baseline, progress=progress, **settings)
    if arguments.json:
        print_json({"command_line": arguments.command_line, **comparison.to_dict()})
    else:
        print(comparison)
        print(f"Made by: {arguments.command_line}")
    return 0
