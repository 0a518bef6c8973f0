"""`beltsort explain`: explain an action of a run."""

from argparse import Namespace

from beltsort._core import DEFAULT_TREE_DEPTH
from beltsort.cli.arguments import Subparsers, add_json
from beltsort.cli.output import action_as_json, print_json, print_table
from beltsort.cli.show import add_run
from beltsort.planning.explanation import action_in_words, explain, tree_in_names
from beltsort.sorting.audit import Step, entries_of, incidents_of, step_of
from beltsort.sorting.entry_text import EntryFormatter


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "explain",
        help="explain an action of a run",
        description="Print the belief at one planner step of a run, and why its action was chosen.",
    )
    add_run(parser)
    parser.add_argument("--step", type=int, required=True, metavar="N", help="planner step, from 1")
    parser.add_argument(
        "--depth",
        type=int,
        default=DEFAULT_TREE_DEPTH,
        metavar="D",
        help="planner steps to explain (default: %(default)s)",
    )
    add_json(parser)
    parser.set_defaults(run=run)


def run(arguments: Namespace) -> int:
    """Find the step, plan again from its belief, and print."""
    entries = entries_of(arguments.folder)
    step = step_of(entries, arguments.step)
    failures = list(incidents_of(entries, step))
    if arguments.json:
        during = [{"kind": entry.kind, **entry.data} for entry in failures]
        print_json(as_json(step, arguments.depth) | {"befell": during})
        return 0
    show(step, arguments.depth)
    if failures:
        formatter = EntryFormatter()
        formatter.format(entries[0])  # names of classes and viewpoints
        print("\nWhile it was carried out:")
        for entry in failures:
            print(f"  {formatter.format(entry)}")
    return 0


def as_json(step: Step, depth: int) -> dict[str, object]:
    """Return the step as plain data."""
    plan = step.plan_again()
    return {
        "step": step.number,
        "time": step.entry.time,
        "object": step.entry.object,
        "viewpoint": step.model.viewpoints[step.viewpoint],
        "belief": step.belief.probabilities.tolist(),
        "action": action_as_json(step.model, step.action),
        "reason": step.reason,
        "drift_alarms": step.alarms,
        "same_again": None if plan is None else plan.action == step.action,
        "tree": None if plan is None else tree_in_names(step.model, plan.tree(depth)),
    }


def show(step: Step, depth: int) -> None:
    """Print the step in words."""
    model = step.model
    at = f"object {step.entry.object or 0} at the belt end, camera at {model.viewpoints[step.viewpoint]}"
    print(f"Step {step.number}, {step.entry.time[:19].replace('T', ' ')} UTC: {at}. Belief:")
    rows = enumerate(step.belief.probabilities.tolist())
    print_table([["position", *model.classes], *([str(j), *(f"{p:.3f}" for p in row)] for j, row in rows)])
    if step.alarms:
        print(
            f"\nAfter {step.alarms} drift alarms: belief and values are based on observation tables that no "
            "longer hold."
        )
    print(f"\nIt was chosen to {action_in_words(model, step.action)}.")
    if step.reason is not None:
        print(f"A rule chose: {step.reason}.")
        return
    plan = step.plan_again()
    if plan is None:
        print("It was chosen by a policy that returns no action values.")
        return
    print(explain(model, plan, depth))
    if plan.action != step.action:
        print(
            "(Planning again with the same number of trials gives another action, since the budget was in "
            "seconds.)"
        )
