"""`beltsort explain`: why a run did what it did."""

from argparse import Namespace
from collections.abc import Sequence

from beltsort.cli.arguments import Subparsers, add_json
from beltsort.cli.narrate import Narrator
from beltsort.cli.output import action_as_json, print_json, print_table
from beltsort.cli.show import add_run
from beltsort.planning.explanation import action_in_words, explain, tree_in_names
from beltsort.sorting.audit import Step, befell, entries_of, step_of
from beltsort.sorting.journal import Entry


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "explain",
        help="say why a run did what it did",
        description="Say what was known at one planner step of a run, and why its action was chosen.",
    )
    add_run(parser)
    parser.add_argument("--step", type=int, required=True, metavar="N", help="planner step, from 1")
    parser.add_argument(
        "--depth", type=int, default=2, metavar="D", help="planner steps to tell of (default: 2)"
    )
    add_json(parser)
    parser.set_defaults(run=run)


def run(arguments: Namespace) -> int:
    """Find the step, plan once more, and tell."""
    entries = entries_of(arguments.folder)
    step = step_of(entries, arguments.step)
    mishaps = list(befell(entries, step))
    if arguments.json:
        befallen = [{"kind": entry.kind, **entry.data} for entry in mishaps]
        print_json(as_json(step, arguments.depth) | {"befell": befallen})
        return 0
    show(step, arguments.depth)
    show_mishaps(entries[0], mishaps)
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
        print(f"\nAfter {step.alarms} drift alarms: belief and values rest on tables that no longer hold.")
    print(f"\nIt was chosen to {action_in_words(model, step.action)}.")
    if step.reason is not None:
        print(f"A rule chose: {step.reason}.")
        return
    plan = step.plan_again()
    if plan is None:
        print("A policy without values chose.")
        return
    print(explain(model, plan, depth))
    if plan.action != step.action:
        print(
            "(Planned again, with as many trials, something else looks better: the budget was one of time.)"
        )


def show_mishaps(first: Entry, mishaps: Sequence[Entry]) -> None:
    """Print what went otherwise than planned; the run's first entry tells the names."""
    narrator = Narrator()
    narrator.line(first)
    if mishaps:
        print("\nWhile it was carried out:")
    for entry in mishaps:
        print(f"  {narrator.line(entry)}")
