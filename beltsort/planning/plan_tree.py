"""The searched tree of a plan as plain data, ready for JSON: what `Plan.tree` returns."""

from typing import TypedDict

NamedAction = dict[str, int]
"""`{"move": viewpoint}` or `{"decide": label}`, as the journal keeps it."""


class TreeNode(TypedDict):
    """A belief of the tree; values are expected discounted rewards as seen from there.

    Attributes
    ----------
    viewpoint
        Where the camera stands.
    belief
        H lists of L probabilities, the belt end first.
    value
        Estimate.
    lower, upper
        The search's own bounds.
    scenarios
        How many come there; None where the search has not been.
    actions
        Those that the search compared; none where it has not been, and none at the last step asked for.
    """

    viewpoint: int
    belief: list[list[float]]
    value: float
    lower: float
    upper: float
    scenarios: int | None
    actions: list["TreeAction"]


class TreeAction(TypedDict):
    """An action of the tree; of all decisions the best one stands for all.

    Attributes
    ----------
    action
        Which one.
    value, lower, upper
        As in `TreeNode`.
    branches
        What it may lead to, the likeliest first; labels that no scenario gives are missing.
    """

    action: NamedAction
    value: float
    lower: float
    upper: float
    branches: list["TreeBranch"]


class TreeBranch(TypedDict):
    """What an action may lead to.

    Attributes
    ----------
    probability
        Of these labels, after the action.
    labels
        One per position, the belt end first; None if no scan follows the action.
    node
        The belief after it.
    """

    probability: float
    labels: list[int] | None
    node: TreeNode
