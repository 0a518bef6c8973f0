from typing import Any, final

from beltsort._stubs.actions import DecideAt, Move, Wait
from beltsort._stubs.moving_belief import MovingBelief
from beltsort._stubs.moving_belt import MovingBelt

@final
class MovingThreshold:
    """Decide an object once the best decision is likely enough to be right, or at its last chance.

    The threshold falls linearly from the entry of the last place to the exit: optimal thresholds fall towards
    a deadline where all places see alike. At its last chance, when it would pass the exit during the next
    look and the decisions in front of it, an object is decided if that is worth more than missing it. On a
    belt that advances on decisions the threshold is `high`.

    Parameters
    ----------
    belt : MovingBelt
        Model, durations and prices.
    high : float
        Threshold at the entry, above 0 and at most 1.
    low : float, optional
        Threshold at the exit, not above `high`; the same if missing.
    rule : {"most-urgent", "information-per-tick"}, default "most-urgent"
        Look from where most is learnt about the undecided object nearest to the exit, or from where most is
        learnt per tick about all undecided objects.

    Raises
    ------
    ArgumentError
        For thresholds out of range, or another rule.

    References
    ----------
    Frazier & Yu, "Sequential hypothesis testing under stochastic deadlines", NIPS 2007.

    Examples
    --------
    >>> import beltsort
    >>> model = beltsort.SortingModel(["nut", "bolt"], ["front"], [[[[0.8, 0.2], [0.2, 0.8]]]])
    >>> belt = beltsort.MovingBelt(model, ticks_per_place=4)
    >>> policy = beltsort.MovingThreshold(belt, 0.9)
    >>> policy.act(belt.belief(), 0)
    Move(viewpoint=0)
    >>> policy.act(beltsort.MovingBelief(belt, kinds=[[0.05, 0.95]]), 0)
    DecideAt(position=0, label=1)
    """

    def __new__(
        cls, belt: MovingBelt, high: float, low: float | None = None, rule: str = "most-urgent"
    ) -> MovingThreshold: ...
    def act(self, belief: MovingBelief, viewpoint: int | str) -> Move | Wait | DecideAt:
        """Decide at the threshold or the last chance, look or wait otherwise.

        Parameters
        ----------
        belief : MovingBelief
            What is known of the objects; made for the policy's belt, or an equal one.
        viewpoint : int or str
            Where the camera stands: index or name.

        Returns
        -------
        Move, Wait or DecideAt
            The action.

        Raises
        ------
        ArgumentError
            For a belief of another belt or an unknown viewpoint.
        """
    @property
    def belt(self) -> MovingBelt:
        """The belt that the policy was made for."""
    @property
    def settings(self) -> dict[str, Any]:
        """What the policy was made with, as keywords of the constructor: high, low, rule."""
    def __copy__(self) -> MovingThreshold: ...
    def __deepcopy__(self, _memo: Any) -> MovingThreshold: ...
    def __getnewargs_ex__(self) -> tuple[tuple[MovingBelt], dict[str, Any]]: ...

@final
class MovingPlanner:
    """Plan for a belt of constant speed: a search over exact beliefs with a clock.

    Preparing solves the problem of one object with a deadline, which takes seconds for models of many
    classes.

    Parameters
    ----------
    belt : MovingBelt
        Model, durations and prices; of constant speed.
    seconds : float, optional
        Wall-clock budget of a plan in seconds, 0.01 if neither budget is given.
    trials : int, optional
        Budget of a plan in trials, in place of `seconds`.
    scenarios : int
        Scenarios that choose which label vectors get a branch.
    seed : int
        Seed of the scenarios.
    depth : int
        Actions to look ahead.
    optimism : float
        How far an estimate at a leaf lies from the default policy's value, 0, to the upper bound, 1.

    Raises
    ------
    ArgumentError
        For a belt that advances on decisions, or counts or budgets that make no sense.

    Examples
    --------
    >>> import beltsort
    >>> model = beltsort.SortingModel(["nut", "bolt"], ["front"], [[[[0.8, 0.2], [0.2, 0.8]]]])
    >>> belt = beltsort.MovingBelt(model, ticks_per_place=4)
    >>> planner = beltsort.MovingPlanner(belt, trials=50)
    >>> planner.plan(belt.belief()).action
    Move(viewpoint=0)
    >>> planner.act(beltsort.MovingBelief(belt, kinds=[[0.001, 0.999]]), 0)
    DecideAt(position=0, label=1)
    """

    def __new__(
        cls,
        belt: MovingBelt,
        *,
        seconds: float | None = None,
        trials: int | None = None,
        scenarios: int = ...,
        seed: int = 0,
        depth: int = ...,
        optimism: float = ...,
    ) -> MovingPlanner: ...
    def plan(
        self,
        belief: MovingBelief,
        viewpoint: int | str = 0,
        *,
        seconds: float | None = None,
        trials: int | None = None,
    ) -> MovingPlan:
        """Plan the next action.

        Parameters
        ----------
        belief : MovingBelief
            What is known of the objects; made for the planner's belt, or an equal one.
        viewpoint : int or str
            Where the camera stands: index or name.
        seconds, trials : optional
            In place of the planner's own budget; at most one of them.

        Returns
        -------
        MovingPlan
            The action, the values it was compared by, and bounds.

        Raises
        ------
        ArgumentError
            For a belief of another belt, an unknown viewpoint, or nothing left to decide.
        """
    def act(self, belief: MovingBelief, viewpoint: int | str) -> Move | Wait | DecideAt:
        """Return the action of a plan.

        Parameters
        ----------
        belief : MovingBelief
            As for `plan`.
        viewpoint : int or str
            Where the camera stands: index or name.

        Returns
        -------
        Move, Wait or DecideAt
            The action.

        Raises
        ------
        ArgumentError
            As `plan`.
        """
    def thresholds(self, label: int, viewpoint: int | str = 0) -> list[float | None]:
        """Return the thresholds at which one object alone is best decided at once.

        Parameters
        ----------
        label : int
            Index of a class.
        viewpoint : int or str
            Where the camera stands: index or name.

        Returns
        -------
        list of float or None
            By ticks left until the exit, from 1 to H `ticks_per_place`: the least probability of the class
            from which on deciding is optimal (within the accuracy of a belief grid), the other classes in
            their proportions at arrival; None out of reach, or where it never is.

        Raises
        ------
        ArgumentError
            For an unknown class or viewpoint.
        """
    @property
    def shares(self) -> list[float]:
        """The share of a look's cost that each object pays in the upper bound, by ticks left from 1."""
    @property
    def belt(self) -> MovingBelt:
        """The belt planned for."""
    @property
    def settings(self) -> dict[str, Any]:
        """What plans depend on besides the belt, as keywords of the constructor."""
    def __copy__(self) -> MovingPlanner: ...
    def __deepcopy__(self, _memo: Any) -> MovingPlanner: ...
    def __getnewargs_ex__(self) -> tuple[tuple[MovingBelt], dict[str, Any]]: ...

@final
class MovingPlan:
    """What a search for a moving belt found. Values are expected rewards, discounted per tick.

    Examples
    --------
    >>> import beltsort
    >>> model = beltsort.SortingModel(["nut", "bolt"], ["front"], [[[[0.8, 0.2], [0.2, 0.8]]]])
    >>> belt = beltsort.MovingBelt(model, ticks_per_place=4)
    >>> plan = beltsort.MovingPlanner(belt, trials=50).plan(belt.belief())
    >>> plan.lower < plan.values[plan.action] < plan.upper
    True
    """

    @property
    def action(self) -> Move | Wait | DecideAt:
        """The action to take: `Move`, `Wait` or `DecideAt`."""
    @property
    def values(self) -> dict[Move | Wait | DecideAt, float]:
        """Estimated value of each action that was compared: dict of action to float."""
    @property
    def lower(self) -> float:
        """Lower bound of the optimal value: what a policy that can be executed earns."""
    @property
    def upper(self) -> float:
        """Upper bound of the optimal value."""
    @property
    def trials(self) -> int:
        """Trials done; fewer than allowed if nothing was left to find."""
    @property
    def seconds(self) -> float:
        """Wall-clock time spent, in seconds."""
    @property
    def expansions(self) -> int:
        """Belief nodes whose actions were all generated."""
    @property
    def nodes(self) -> int:
        """Belief nodes created."""
