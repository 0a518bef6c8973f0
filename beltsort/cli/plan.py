"""`beltsort plan`: plan the next action."""

from argparse import Namespace
from pathlib import Path
from typing import Any

from beltsort import ArgumentError, Belief, Despot, Plan, Solution, SortingModel
from beltsort._core import DEFAULT_SCENARIOS, DEFAULT_TREE_DEPTH
from beltsort.cli.arguments import (
    Subparsers,
    add_budget,
    add_json,
    add_model,
    add_whole_tree,
    budget_of,
    load_model,
)
from beltsort.cli.output import action_as_json, print_json, print_table
from beltsort.planning.display.text import belief_lines
from beltsort.planning.explanation import action_in_words, explain, tree_in_names
from beltsort.util.naming import index_of, split_names

NOTHING_SEEN = "-"

EXAMPLE = "beltsort plan paper --observe p1=livarno,standard --explain"


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser = subparsers.add_parser("plan", help="plan the next action after the given scans")
    add_model(parser)
    parser.add_argument(
        "--observe",
        action="append",
        default=[],
        metavar="P=LABEL,LABEL",
        help="a scan: its viewpoint and a label per position, position 1 at the belt end first, - where "
        "nothing was seen; names or indices; may be repeated, in the order of the scans",
    )
    parser.add_argument(
        "--viewpoint",
        metavar="P",
        help="current viewpoint of the camera (default: that of the last scan, else the first one)",
    )
    parser.add_argument(
        "--remaining",
        type=int,
        metavar="N",
        help="objects left, including the one at the belt end (default: the belt never ends)",
    )
    add_budget(parser)
    parser.add_argument(
        "--scenarios",
        type=int,
        default=DEFAULT_SCENARIOS,
        metavar="N",
        help="number of scenarios (default: %(default)s)",
    )
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="seed of the scenarios (default: 0)")
    parser.add_argument(
        "--solution",
        type=Path,
        metavar="FILE",
        help="solution of the model, written by `beltsort solve`, for tighter bounds of the optimal value",
    )
    parser.add_argument(
        "--explain", action="store_true", help="print why the action was chosen, and the likely next steps"
    )
    parser.add_argument(
        "--depth",
        type=int,
        default=DEFAULT_TREE_DEPTH,
        metavar="D",
        help="planner steps that --explain covers (default: %(default)s)",
    )
    add_whole_tree(parser)
    add_json(parser)
    parser.set_defaults(run=run)


def run(arguments: Namespace) -> int:
    """Observe, plan and print."""
    model = load_model(arguments)
    belief, viewpoint = Belief(model, remaining=arguments.remaining), 0
    for scan in arguments.observe:
        viewpoint, labels = parse_scan(scan, model)
        belief.observe(viewpoint, labels)
    if arguments.viewpoint is not None:
        viewpoint = index_of(arguments.viewpoint, model.viewpoints, "viewpoint")
    planner = Despot(
        model,
        scenarios=arguments.scenarios,
        seed=arguments.seed,
        solution=None if arguments.solution is None else Solution.load(arguments.solution, model),
        **budget_of(arguments),
    )
    plan = planner.plan(belief, viewpoint)
    if arguments.json:
        printed = as_json(model, belief, viewpoint, plan)
        if arguments.explain:
            printed["tree"] = tree_in_names(model, plan, arguments.depth, whole_tree=arguments.whole_tree)
        print_json(printed)
        return 0
    show(model, belief, viewpoint, plan)
    if arguments.explain:
        print(f"\n{explain(model, plan, arguments.depth)}")
    return 0


def parse_scan(text: str, model: SortingModel) -> tuple[int, list[int | None]]:
    """Parse one `P=LABEL,LABEL`."""
    viewpoint, equals, labels = text.partition("=")
    if not equals:
        raise ArgumentError(f"--observe {text}: expected VIEWPOINT=LABEL,LABEL with a label per position")
    return (
        index_of(viewpoint, model.viewpoints, "viewpoint"),
        [
            None if label == NOTHING_SEEN else index_of(label, model.labels, "label")
            for label in split_names(labels, model.labels)
        ],
    )


def as_json(model: SortingModel, belief: Belief, viewpoint: int, plan: Plan) -> dict[str, Any]:
    """Return the plan as plain data."""
    return {
        "viewpoint": model.viewpoints[viewpoint],
        "belief": [dict(zip(model.classes, row, strict=True)) for row in belief.probabilities.tolist()],
        "action": action_as_json(model, plan.action),
        "values": [
            {"action": action_as_json(model, action), "value": value} for action, value in plan.values.items()
        ],
        "lower": plan.lower,
        "upper": plan.upper,
        "certified_lower": plan.certified_lower,
        "certified_upper": plan.certified_upper,
        "trials": plan.trials,
        "seconds": plan.seconds,
    }


def show(model: SortingModel, belief: Belief, viewpoint: int, plan: Plan) -> None:
    """Print the plan in words."""
    print("Belief, position 1 at the belt end:")
    print("\n".join(belief_lines(belief)))
    print(f"\nThe camera stands at {model.viewpoints[viewpoint]}.")
    print(f"Next: {action_in_words(model, plan.action)}.")
    print("\nEstimated value of each action (expected discounted reward), and its gap to the best:")
    best_first = sorted(plan.values.items(), key=lambda entry: -entry[1])
    best = best_first[0][1]
    print_table(
        [
            (action_in_words(model, action), f"{value:.3f}", f"{best - value:.3f}")
            for action, value in best_first
        ]
    )
    print(
        f"\nThe values are estimates. Bounds of the search's own problem, planned for sampled labels only: "
        f"{plan.lower:.3f} to {plan.upper:.3f}."
    )
    certified = f"at most {plan.certified_upper:.3f}"
    if plan.certified_lower is not None:
        certified = f"{plan.certified_lower:.3f} to {plan.certified_upper:.3f}"
    print(f"Certified bounds of the optimal value: {certified}.")
    if plan.certified_lower is not None and plan.certified_upper is not None:
        loss = plan.certified_upper - plan.certified_lower
        print(f"Following the planned policy loses at most {loss:.3f} against an optimal one.")
    print(f"{plan.trials} trials in {plan.seconds:.3f} s.")
