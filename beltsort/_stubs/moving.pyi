from collections.abc import Sequence
from typing import Any, final

from numpy.typing import ArrayLike

from beltsort._stubs.actions import DecideAt, Move, Wait
from beltsort._stubs.belief import Belief
from beltsort._stubs.model import SortingModel

@final
class MovingPlanner:
    """Plan for a belt that never stops: a search over exact beliefs with a clock.

    Time runs in ticks. The belt carries every object one place further every `ticks_per_place`, whatever is
    decided. A look moves the camera and scans at the end of its ticks. An object is decided while it is in
    reach; one that passes the exit undecided costs `missed`. The model's discount is per tick.

    Preparing solves the problem of one object with a deadline, which takes seconds for models of many
    classes.

    Parameters
    ----------
    model : SortingModel
        Classes, tables and rewards. `repeat`, `observe_after_decision` and `information_gain` are refused.
    ticks_per_place : int
        Ticks between two advances of the belt.
    reach : int, default 1
        Places, from the exit, at which objects can be decided.
    move_ticks : int or array of shape (K, K), default 1
        Ticks of the camera's moves. A look takes at least one tick.
    scan_ticks : int, default 0
        Ticks of a scan.
    sort_ticks : int, default 0
        Ticks of a decision, in which the camera waits.
    missed : sequence of L floats, optional
        Price of an object that passes the exit undecided, per class, not negative; if missing, 0 for the
        model's `empty` class, and the largest reward for the others.
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
        For times, prices, counts or budgets that make no sense.
    ModelError
        For a model with keys that are not supported.

    Examples
    --------
    >>> import beltsort
    >>> model = beltsort.SortingModel(["nut", "bolt"], ["front"], [[[[0.8, 0.2], [0.2, 0.8]]]])
    >>> planner = beltsort.MovingPlanner(model, ticks_per_place=4, trials=50)
    >>> planner.plan(beltsort.Belief(model)).action
    Move(viewpoint=0)
    >>> planner.plan(beltsort.Belief(model, [[0.001, 0.999]])).action
    DecideAt(position=0, label=1)
    """

    def __new__(
        cls,
        model: SortingModel,
        *,
        ticks_per_place: int,
        reach: int = 1,
        move_ticks: ArrayLike | None = None,
        scan_ticks: int = 0,
        sort_ticks: int = 0,
        missed: Sequence[float] | None = None,
        seconds: float | None = None,
        trials: int | None = None,
        scenarios: int = ...,
        seed: int = 0,
        depth: int = ...,
        optimism: float = ...,
    ) -> MovingPlanner: ...
    def plan(
        self,
        belief: Belief,
        viewpoint: int | str = 0,
        *,
        decided: Sequence[int] = (),
        offset: int = 0,
        to_come: int | None = None,
        seconds: float | None = None,
        trials: int | None = None,
    ) -> MovingPlan:
        """Plan the next action.

        Parameters
        ----------
        belief : Belief
            What is known of the objects at the H places, the one nearest to the exit first.
        viewpoint : int or str
            Where the camera stands: index or name.
        decided : sequence of int
            Places whose object is decided already, or that are empty.
        offset : int
            Ticks since the belt last advanced, below `ticks_per_place`.
        to_come : int, optional
            Objects that have not come to a place yet; if missing, the belt never ends.
        seconds, trials : optional
            In place of the planner's own budget; at most one of them.

        Returns
        -------
        MovingPlan
            The action, the values it was compared by, and bounds.

        Raises
        ------
        ArgumentError
            For a belief of another model, places or times that do not exist, or nothing left to decide.
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
    def model(self) -> SortingModel:
        """The model planned for."""
    @property
    def settings(self) -> dict[str, Any]:
        """What plans depend on, as keywords of the constructor."""
    def __getnewargs_ex__(self) -> tuple[tuple[SortingModel], dict[str, Any]]: ...

@final
class MovingPlan:
    """What a search for a belt that never stops found. Values are expected rewards, discounted per tick.

    Examples
    --------
    >>> import beltsort
    >>> model = beltsort.SortingModel(["nut", "bolt"], ["front"], [[[[0.8, 0.2], [0.2, 0.8]]]])
    >>> planner = beltsort.MovingPlanner(model, ticks_per_place=4, trials=50)
    >>> plan = planner.plan(beltsort.Belief(model))
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
