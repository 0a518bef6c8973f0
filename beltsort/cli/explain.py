"""`beltsort explain`: explain an action of a run."""

from argparse import Namespace
from collections.abc import Sequence

from beltsort._core import DEFAULT_TREE_DEPTH
from beltsort.cli.arguments import Subparsers, add_json, add_whole_tree
from beltsort.cli.output import action_as_json, print_json, print_table
from beltsort.cli.show import add_run
from beltsort.planning.display.text import belief_lines
from beltsort.planning.explanation import action_in_words, explain, tree_in_names
from beltsort.sorting.audit import (
    Step,
    entries_of,
    incidents_of,
    step_of,
    steps_of,
)
from beltsort.sorting.entries import Decided, Skipped
from beltsort.sorting.entry_text import EntryFormatter
from beltsort.sorting.journal import Entry
from beltsort.sorting.object_history import ObjectHistory, object_history, objects_in_words
from beltsort.sorting.progress import Progress
from beltsort.util.text import counted, position_number, ranges

EXAMPLE = "beltsort explain runs/2026-01-31T12-00-00.000000Z --object 3"


def add_parser(subparsers: Subparsers) -> None:
    """Add the command."""
    parser = subparsers.add_parser(
        "explain",
        help="explain an action or a decision of a run",
        description="Print the belief at one planner step of a run, and why its action was chosen; or all "
        "looks at one object with the belief after each, and why it was decided as it was. Without --step "
        "and --object, print what can be explained.",
    )
    add_run(parser)
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--step", type=int, metavar="N", help="planner step, from 1")
    what.add_argument(
        "--object", type=int, metavar="N", help="number of an object, as `beltsort show` prints it"
    )
    parser.add_argument(
        "--depth",
        type=int,
        default=DEFAULT_TREE_DEPTH,
        metavar="D",
        help="planner steps to explain (default: %(default)s)",
    )
    add_whole_tree(parser)
    add_json(parser)
    parser.set_defaults(run=run)


def run(arguments: Namespace) -> int:
    """Find the step or the object, plan again from the belief, and print."""
    entries = entries_of(arguments.folder)
    if arguments.object is None and arguments.step is None:
        if arguments.json:
            print_json(run_as_json(entries))
        else:
            show_run(entries, arguments.depth)
        return 0
    if arguments.object is not None:
        history = object_history(entries, arguments.object)
        if arguments.json:
            told = object_as_json(history, arguments.depth, whole_tree=arguments.whole_tree)
            print_json({"object": arguments.object, **told})
        else:
            show_object(history, arguments.depth)
        return 0
    step = step_of(entries, arguments.step)
    failures = list(incidents_of(entries, step))
    if arguments.json:
        during = [{"kind": entry.kind, **entry.data} for entry in failures]
        told = as_json(step, arguments.depth, whole_tree=arguments.whole_tree)
        print_json(told | {"befell": during})
        return 0
    show(step, arguments.depth)
    if failures:
        formatter = EntryFormatter()
        formatter.format(entries[0])  # names of classes and viewpoints
        print("\nWhile it was carried out:")
        for entry in failures:
            print(f"  {formatter.format(entry)}")
    return 0


def run_as_json(entries: Sequence[Entry]) -> dict[str, object]:
    """Return what can be explained as plain data: numbers of objects and of planner steps."""
    progress, steps = Progress.after(entries, keep=None), [step.number for step in steps_of(entries)]
    decided = [decision.object for decision in progress.decisions]
    return {
        "first_object": progress.first,
        "objects": progress.objects,
        "at_belt_end": progress.index,
        "decided": decided,
        "skipped": progress.skipped,
        "passed": progress.passed,
        "steps": sorted(set(steps)),
        "last_decided": decided[-1] if decided else None,
    }


def show_run(entries: Sequence[Entry], depth: int) -> None:
    """Print which objects and steps can be explained, and explain the last decision."""
    progress, steps = Progress.after(entries, keep=None), [step.number for step in steps_of(entries)]
    print(f"The run sorts {objects_in_words(progress)}.")
    groups = {
        "decided": [decision.object for decision in progress.decisions],
        "empty cups": progress.skipped,
        "passed the belt end unsorted": progress.passed,
    }
    for what, numbers in groups.items():
        if numbers:
            print(f"  {what}: {ranges(numbers)}")
    if progress.index < progress.end:
        print(f"  at the belt end: {progress.index}")
    if not steps:
        print("It has taken no planner step yet.")
        return
    print(f"Its planner steps are {ranges(steps)}.")
    print("`--object N` explains what became of an object, `--step N` one step.")
    if progress.decisions:
        print("\nThe last decision:")
        show_object(object_history(entries, progress.decisions[-1].object), depth)


def as_json(step: Step, depth: int, *, whole_tree: bool) -> dict[str, object]:
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
        "tree": None if plan is None else tree_in_names(step.model, plan, depth, whole_tree=whole_tree),
    }


def show(step: Step, depth: int) -> None:
    """Print the step in words."""
    model = step.model
    at = f"object {step.entry.object or 0} at the belt end, camera at {model.viewpoints[step.viewpoint]}"
    print(f"Step {step.number}, {step.entry.time[:19].replace('T', ' ')} UTC: {at}. Belief:")
    print("\n".join(belief_lines(step.belief)))
    if step.alarms:
        print(
            f"\nAfter {step.alarms} drift alarms: belief and values are based on observation tables that no "
            "longer hold."
        )
    print()
    show_reason(step, depth)


def show_reason(step: Step, depth: int) -> None:
    """Print why the step's action was chosen."""
    model = step.model
    print(f"It was chosen to {action_in_words(model, step.action)}.")
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


def object_as_json(history: ObjectHistory, depth: int, *, whole_tree: bool) -> dict[str, object]:
    """Return the history of an object as plain data."""
    model = history.model
    looks = [
        {
            "step": look.step,
            "time": look.entry.time,
            "viewpoint": model.viewpoints[look.viewpoint],
            "position": look.position,
            "label": None if look.label is None else model.labels[look.label],
            "finding": look.finding,
            "belief": look.belief,
        }
        for look in history.looks
    ]
    outcome: dict[str, object] | None = None
    match history.outcome:
        case Decided() as made:
            decided = None if made.label is None else model.bins[made.label]
            outcome = {"decided": decided, "belief": made.belief, "looks": made.looks, "forced": made.forced}
        case Skipped():
            outcome = {"skipped": True}
    why = None if history.step is None else as_json(history.step, depth, whole_tree=whole_tree)
    return {"looks": looks, "outcome": outcome, "decision_step": why}


def show_object(history: ObjectHistory, depth: int) -> None:
    """Print the looks at an object, and why it was decided as it was."""
    model = history.model
    print(f"Object {history.number}, {counted(len(history.looks), 'look')}. Belief after each:")
    rows = [
        [
            str(look.step),
            model.viewpoints[look.viewpoint],
            position_number(look.position),
            look.finding if look.label is None else model.labels[look.label],
            *(f"{p:.3f}" for p in look.belief),
        ]
        for look in history.looks
    ]
    if rows:
        print_table([["step", "from", "position", "label", *model.classes], *rows])
    match history.outcome:
        case Decided() as made:
            into = "the reject bin" if made.label is None else model.bins[made.label]
            looks = counted(made.looks, "look")
            print(f"\nDecided after {looks}: {into}, right with {100 * made.belief:.1f} %.")
        case Skipped():
            print("\nIts cup was skipped as empty.")
        case None:
            print(f"\n{history.undecided}")
    if history.step is not None:
        print(f"Step {history.step.number}: ", end="")
        show_reason(history.step, depth)
