"""The search tree of a plan as plain data, as returned by `Plan.tree`."""

from typing import TypedDict

NamedAction = dict[str, int]
"""`{"move": viewpoint}` or `{"decide": bin}`, the journal's format."""


class TreeNode(TypedDict):
    """A belief node; values are expected discounted rewards from this node on.

    Attributes
    ----------
    viewpoint
        The camera's viewpoint.
    belief
        H lists of L class probabilities, the belt end first.
    value
        Estimate.
    lower, upper
        Bounds of the sampled problem.
    scenarios
        Number of scenarios at the node; None if the node was not expanded.
    actions
        The actions compared; empty if the node was not expanded, or at the requested depth.
    """

    viewpoint: int
    belief: list[list[float]]
    value: float
    lower: float
    upper: float
    scenarios: int | None
    actions: list["TreeAction"]


class TreeAction(TypedDict):
    """An action of a node. Of the decisions only the best one is included.

    Attributes
    ----------
    action
        The action.
    value, lower, upper
        As in `TreeNode`.
    branches
        Branches, the most likely first; label vectors that occur in no scenario are not included.
    """

    action: NamedAction
    value: float
    lower: float
    upper: float
    branches: list["TreeBranch"]


class TreeBranch(TypedDict):
    """A label vector that may be observed after an action.

    Attributes
    ----------
    probability
        Probability of the labels, given the action.
    labels
        One label per position, the belt end first, indices of `SortingModel.labels`; None if no scan
        follows the action.
    node
        The node after the observation.
    """

    probability: float
    labels: list[int] | None
    node: TreeNode
