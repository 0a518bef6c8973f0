"""`beltsort solve`: solve a model offline."""

from argparse import Namespace
from pathlib import Path
from time import monotonic

from beltsort import Solution, solve
from beltsort._core import DEFAULT_SOLVE_SECONDS
from beltsort.cli.arguments import Subparsers, add_json, add_model, check_writable, load_model
from beltsort.cli.output import print_json, print_status
from beltsort.sorting.interrupts import Interrupts

SECONDS_BETWEEN_REPORTS = 2.0

EXAMPLE = "beltsort solve paper --positions 1 --seconds 10 -o paper.solution"


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "solve",
        help="compute certified bounds of the optimal value",
        description="Solve a model offline. Prints certified bounds of the optimal value at the initial "
        "belief: lower <= V*(b0) <= upper. An interrupt (Ctrl-C, SIGTERM) ends it "
        "early: bounds and solution as they are by then are kept, and valid.",
    )
    add_model(parser)
    parser.add_argument(
        "--seconds",
        type=float,
        default=DEFAULT_SOLVE_SECONDS,
        metavar="S",
        help=f"time to spend (default: {DEFAULT_SOLVE_SECONDS:g})",
    )
    parser.add_argument(
        "-o", "--output", type=Path, metavar="FILE", help="save the solution, for `beltsort.Solution.load`"
    )
    add_json(parser)
    parser.set_defaults(run=run)


def run(arguments: Namespace) -> int:
    """Solve, print progress on standard error, and save."""
    model = load_model(arguments)
    if arguments.output is not None:
        check_writable(arguments.output)
    began = reported = monotonic()

    def report(lower: float, upper: float) -> None:
        nonlocal reported
        if monotonic() - reported >= SECONDS_BETWEEN_REPORTS:
            reported = monotonic()
            print_status(f"{reported - began:6.1f} s  {lower:.4f} <= V* <= {upper:.4f}")

    with Interrupts(at_once=False) as interrupts:
        solution = solve(model, seconds=arguments.seconds, progress=report, stop=lambda: interrupts.received)
        if interrupts.received:
            print_status("interrupted: what has been found up to now is valid")
        print_solution(arguments, solution)
        interrupts.check()
    return 0


def print_solution(arguments: Namespace, solution: Solution) -> None:
    """Save the solution if that is requested, and print its bounds."""
    if arguments.output is not None:
        solution.save(arguments.output)
        print_status(f"saved as {arguments.output}")
    if arguments.json:
        print_json({"lower": solution.lower, "upper": solution.upper, "seconds": solution.seconds})
    else:
        print(f"{solution.lower:.4f} <= V* <= {solution.upper:.4f}  ({solution.seconds:.1f} s)")
