"""Explanation of plans: the search tree in words."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from beltsort._core import DEFAULT_TREE_DEPTH, Decide, Move, Plan, SortingModel
from beltsort.planning.decisions import likeliest_in_words, right_bins
from beltsort.planning.plan_tree import NamedAction, TreeAction, TreeBranch, TreeNode

BRANCHES = 4  # most likely branches of an action that get a line each
NEGLIGIBLE = 0.005  # probability below which the remaining branches get no line


def explain(model: SortingModel, plan: Plan, depth: int = DEFAULT_TREE_DEPTH) -> str:
    """Explain why the plan's action was chosen, and what is likely to follow it.

    Parameters
    ----------
    model
        The planner's model.
    plan
        A plan of that planner.
    depth
        Planner steps to explain: 1 for the possible observations after the action, 2 for the actions after
        them, and so on.

    Returns
    -------
    str
        Several lines of text. Probabilities and beliefs are exact under the model; values are estimates.

    Raises
    ------
    ArgumentError
        If the depth is below 0 or above 1000.

    Examples
    --------
    >>> import beltsort
    >>> model = beltsort.SortingModel(["nut", "bolt"], ["front"], [[[[0.8, 0.2], [0.2, 0.8]]]])
    >>> plan = beltsort.Despot(model, trials=100).plan(beltsort.Belief(model, [[0.3, 0.7]]))
    >>> print(explain(model, plan))
    Deciding bolt now would be right with 70 % and worth 7.0; one more look, from front, is worth 16.2.
    After 'move to front and scan', most likely:
      if it says bolt (62 %): 90 % bolt, then move to front and scan
      if it says nut (38 %): 63 % nut, then move to front and scan
    """
    tree = plan.tree(depth)
    lines = [reason(model, plan, tree["belief"][0])]
    for action in tree["actions"]:
        if _action(action["action"]) == plan.action:
            lines.append(f"After '{action_in_words(model, plan.action)}', most likely:")
            lines += _branch_lines(model, action, depth)
    return "\n".join(lines)


def reason(model: SortingModel, plan: Plan, belief: Sequence[float]) -> str:
    """Return a sentence that compares deciding now with one more look; `belief` is that of the belt end."""
    values = plan.values
    decision = max((action for action in values if isinstance(action, Decide)), key=values.__getitem__)
    looks = [action for action in values if isinstance(action, Move)]
    name = _bin_in_words(model, decision.bin)
    belonging = right_bins(model)[decision.bin]
    # Nothing belongs into a manual bin: only its worth says something about it.
    right = f"right with {_percent(float(np.dot(belonging, belief)))}" if belonging.any() else ""
    worth = f"worth {values[decision]:.1f}"
    if not looks:
        return f"No move is allowed from here; deciding {name} is {right or worth}."
    look = max(looks, key=values.__getitem__)
    from_where, decided = model.viewpoints[look.viewpoint], plan.action == decision
    deciding, looking = ("is", "would be") if decided else ("would be", "is")
    return (
        f"Deciding {name} now {deciding} {f'{right} and ' if right else ''}{worth}; "
        f"one more look, from {from_where}, {looking} worth {values[look]:.1f}."
    )


def action_in_words(model: SortingModel, action: Move | Decide) -> str:
    """Return an action as text."""
    match action:
        case Move(viewpoint):
            return f"move to {model.viewpoints[viewpoint]} and scan"
        case Decide(index) if model.bins == model.classes:
            return f"sort as {model.classes[index]}"
        case Decide(index):
            return f"sort into {_bin_in_words(model, index)}"


def tree_in_names(
    model: SortingModel, plan: Plan, depth: int = DEFAULT_TREE_DEPTH, *, whole_tree: bool = False
) -> dict[str, Any]:
    """Return the searched tree with names of viewpoints, labels, classes and bins in place of indices.

    Parameters
    ----------
    model, plan, depth
        As of `explain`.
    whole_tree
        All actions and branches instead of `chosen_part`.
    """
    tree = plan.tree(depth)
    return _in_names(model, tree if whole_tree else chosen_part(tree, plan.action))


def _in_names(model: SortingModel, tree: TreeNode) -> dict[str, Any]:
    def action_in_names(action: TreeAction) -> dict[str, Any]:
        ((kind, index),) = action["action"].items()
        name = (model.viewpoints if kind == "move" else model.bins)[index]
        return {**action, "action": {kind: name}, "branches": [*map(branch_in_names, action["branches"])]}

    def branch_in_names(branch: TreeBranch) -> dict[str, Any]:
        return {**branch, "labels": _names(model, branch), "node": _in_names(model, branch["node"])}

    return {
        **tree,
        "viewpoint": model.viewpoints[tree["viewpoint"]],
        "belief": [dict(zip(model.classes, row, strict=True)) for row in tree["belief"]],
        "actions": [*map(action_in_names, tree["actions"])],
    }


def chosen_part(tree: TreeNode, action: Move | Decide) -> TreeNode:
    """Return the part of a tree that follows an action: what `explain` puts into words.

    Parameters
    ----------
    tree
        From `Plan.tree`.
    action
        The action chosen at the root.

    Returns
    -------
    TreeNode
        All actions of the root with their values. The action, and the best action of each later node, keep
        their most likely branches; other actions have none at the root, and are left out later.
    """
    actions: list[TreeAction] = []
    for each in tree["actions"]:
        branches = _likeliest(each) if _action(each["action"]) == action else []
        actions.append({**each, "branches": branches})
    return {**tree, "actions": actions}


def _likeliest(action: TreeAction) -> list[TreeBranch]:
    """Return an action's most likely branches, each followed by best actions only."""
    return [{**branch, "node": _best_only(branch["node"])} for branch in action["branches"][:BRANCHES]]


def _best_only(node: TreeNode) -> TreeNode:
    best = max(node["actions"], key=lambda action: action["value"], default=None)
    return {**node, "actions": [] if best is None else [{**best, "branches": _likeliest(best)}]}


def _branch_lines(model: SortingModel, action: TreeAction, depth: int, indent: str = "  ") -> Iterator[str]:
    """Yield a line for each of the likeliest branches, followed by `depth` - 1 further planner steps."""
    likeliest = action["branches"][:BRANCHES]
    for branch in likeliest:
        node = branch["node"]
        best = max(node["actions"], key=lambda action: action["value"], default=None)
        line = f"{indent}{_posterior(model, branch)}"
        if depth > 1 and node["belief"]:
            line += (
                ", not searched further"
                if best is None
                else f", then {action_in_words(model, _action(best['action']))}"
            )
        yield line
        if best is not None and depth > 2:
            yield from _branch_lines(model, best, depth - 1, indent + "    ")
    others = 1.0 - sum(branch["probability"] for branch in likeliest)
    if others > NEGLIGIBLE:
        yield f"{indent}anything else ({_percent(others)})"


def _posterior(model: SortingModel, branch: TreeBranch) -> str:
    """Return the labels of a branch, and the most likely class at the belt end after them."""
    if not branch["node"]["belief"]:
        return "no object is left"
    row = branch["node"]["belief"][0]
    named, percent = likeliest_in_words(row, model.classes), _percent(max(row))
    most_likely = f"{percent} {named}" if named in model.classes else f"{named}, {percent} each"
    names = _names(model, branch)
    if names is None:
        return f"the next object is {most_likely}"
    said = ", ".join(f'"{name}"' if "," in name else name for name in names)
    return f"if it says {said} ({_percent(branch['probability'])}): {most_likely}"


def _names(model: SortingModel, branch: TreeBranch) -> list[str] | None:
    labels = branch["labels"]
    return None if labels is None else [model.labels[label] for label in labels]


def _bin_in_words(model: SortingModel, index: int) -> str:
    """Return the class that a bin is of, or the bin itself where bins are not the classes."""
    return model.bins[index] if model.bins == model.classes else f"bin {model.bins[index]}"


def _action(named: NamedAction) -> Move | Decide:
    return Move(named["move"]) if "move" in named else Decide(named["decide"])


def _percent(probability: float) -> str:
    return f"{100 * probability:.0f} %"
