from typing import final

from beltsort._stubs.actions import Decide, Move
from beltsort._stubs.model import SortingModel
from beltsort.planning.plan_tree import TreeNode

@final
class Plan:
    """What a search found. Values are expected discounted rewards, in the unit of `r_max` and `r_min`.

    `values` are estimates: the search's lower bound, plus what the default policy is expected to fall short
    of the best one by wherever the search has not looked. The action is chosen by them. `lower` and `upper`
    bound the search's own problem, and its `upper` may lie below the estimates; `certified_lower` and
    `certified_upper` bound the optimal value of the model itself. Of DESPOT as published (variant
    "scenarios") `values` are lower bounds in the sampled, regularised problem.

    Examples
    --------
    >>> import beltsort
    >>> model = beltsort.SortingModel(["nut", "bolt"], ["front"], [[[[0.8, 0.2], [0.2, 0.8]]]])
    >>> plan = beltsort.Despot(model, trials=10).plan(beltsort.Belief(model))
    >>> plan.lower < plan.values[plan.action] < plan.upper
    True
    >>> [action["action"] for action in plan.tree(depth=1)["actions"]]
    [{'decide': 0}, {'move': 0}]
    """

    @property
    def action(self) -> Move | Decide:
        """The action to take, `Move` or `Decide`."""
    @property
    def values(self) -> dict[Move | Decide, float]:
        """Estimated value of every legal action: dict of `Move` or `Decide` to float."""
    @property
    def lower(self) -> float:
        """Lower bound of the optimum of the search's own (sampled, regularised) problem."""
    @property
    def upper(self) -> float:
        """Upper bound of the same optimum."""
    @property
    def certified_lower(self) -> float | None:
        """Lower bound of V*, the optimal value of the model itself, or None.

        It is what a policy that can be executed earns from here; None if the model repeats looks, and of
        DESPOT as published.
        """
    @property
    def certified_upper(self) -> float:
        """Upper bound of V*."""
    @property
    def trials(self) -> int:
        """Trials done; fewer than allowed if the sampled problem was solved before."""
    @property
    def seconds(self) -> float:
        """Wall-clock time spent, in seconds."""
    @property
    def scenario_steps(self) -> int:
        """(scenario, move) pairs simulated at expanded nodes."""
    @property
    def expansions(self) -> int:
        """Belief nodes whose actions were all generated."""
    @property
    def nodes(self) -> int:
        """Belief nodes created."""
    @property
    def model(self) -> SortingModel:
        """The model planned for."""
    def tree(self, depth: int = ...) -> TreeNode:
        """Return the searched tree as plain data, ready for JSON: why the action was chosen.

        Parameters
        ----------
        depth : int
            Planner steps below the root, 0 to 1000. With K moves and H positions, every step multiplies the
            tree by up to K L^H.

        Returns
        -------
        dict
            A belief of the tree: `viewpoint`; `belief`, H lists of L probabilities; `value`, `lower` and
            `upper` as seen from there; `scenarios` that come there, None where the search has not been; and
            `actions`, a list that is empty where the search has not been and at the last step asked for. Each
            is a dict of `action` (``{"move": viewpoint}`` or ``{"decide": label}``; of all decisions the best
            one stands for all), `value`, `lower`, `upper` and `branches`, the likeliest first. Each of these
            is a dict of `probability`, `labels` (one per position, or None without a scan) and `node`, the
            belief after it; labels that no scenario gives are missing.

        Raises
        ------
        ArgumentError
            For a depth below 0 or above 1000, or a plan of `Despot(variant="scenarios")`, which keeps no
            tree.
        """
    def _repr_html_(self) -> str:
        """Return HTML for notebooks."""
    def __copy__(self) -> Plan: ...
    def __deepcopy__(self, _memo: object) -> Plan: ...
