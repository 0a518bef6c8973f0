"""`beltsort solve`: certified bounds of a model's optimal value."""

import os
from argparse import Namespace
from pathlib import Path
from time import monotonic

from beltsort import ArgumentError, solve
from beltsort.cli.arguments import Subparsers, add_json, add_model, load_model
from beltsort.cli.output import print_json, tell

SECONDS_BETWEEN_REPORTS = 2.0


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "solve",
        help="certified bounds of the optimal value",
        description="Solve a model offline: lower <= V*(b0) <= upper, both proved.",
    )
    add_model(parser)
    parser.add_argument(
        "--seconds", type=float, default=60.0, metavar="S", help="time to spend (default: 60)"
    )
    parser.add_argument(
        "-o", "--output", type=Path, metavar="FILE", help="save the solution, for `beltsort.Solution.load`"
    )
    add_json(parser)
    parser.set_defaults(run=run)


def run(arguments: Namespace) -> int:
    """Solve, reporting on standard error."""
    model = load_model(arguments)
    if arguments.output is not None:
        check_writable(arguments.output)
    began = told = monotonic()

    def report(lower: float, upper: float) -> None:
        nonlocal told
        if monotonic() - told >= SECONDS_BETWEEN_REPORTS:
            told = monotonic()
            tell(f"{told - began:6.1f} s  {lower:.4f} <= V* <= {upper:.4f}")

    solution = solve(model, seconds=arguments.seconds, progress=report)
    if arguments.output is not None:
        solution.save(arguments.output)
        tell(f"saved as {arguments.output}")
    if arguments.json:
        print_json({"lower": solution.lower, "upper": solution.upper, "seconds": solution.seconds})
    else:
        print(f"{solution.lower:.4f} <= V* <= {solution.upper:.4f}  ({solution.seconds:.1f} s)")
    return 0


def check_writable(path: Path) -> None:
    """Refuse a path that no solution can be written to, before time is spent on one."""
    if path.is_dir():
        raise ArgumentError(f"{path} is a directory; name a file")
    if not path.parent.is_dir():
        raise ArgumentError(f"{path}: there is no directory {path.parent}; make it first")
    if not os.access(path.parent, os.W_OK):
        raise ArgumentError(f"{path}: the directory {path.parent} cannot be written to; name another")
