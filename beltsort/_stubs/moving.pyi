from collections.abc import Sequence
from os import PathLike
from typing import Any, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from beltsort._stubs.actions import DecideAt, Move, Wait
from beltsort._stubs.model import SortingModel
from beltsort.planning.moving import MovingStatistics
from beltsort.planning.policy import MovingPolicy

@final
class MovingBelt:
    """A sorting model on a belt that moves while the camera looks.

    Time runs in ticks. A belt of constant speed carries every object one place further every
    `ticks_per_place`, whatever is decided; an object that passes the exit undecided costs `missed`. With
    `advance_ticks` in its place the belt stands, and advances by one place after each decision on the object
    nearest to the exit, as in the paper. An object is seen at the H places of the model's tables and decided
    while it is in reach. A look moves the camera and scans at the end of its ticks, at least one; its cost is
    the model's. The model's discount is per tick.

    Parameters
    ----------
    model : SortingModel
        Classes, tables and rewards. `repeat`, `observe_after_decision` and `information_gain` are refused.
    ticks_per_place : int, optional
        Ticks between two advances of a belt of constant speed.
    advance_ticks : int, optional
        Ticks of a decision and the advance after it, at least one; in place of `ticks_per_place`.
    reach : int, default 1
        Places, from the exit, at which objects can be decided.
    move_ticks : int or array of shape (K, K), default 1
        Ticks of the camera's moves, ``[start, end]``.
    scan_ticks : int, default 0
        Ticks of a scan.
    sort_ticks : int, default 0
        Ticks of a decision, in which the camera waits.
    missed : sequence of L floats, optional
        Price of an object that passes the exit undecided, per class, not negative; if missing, 0 for the
        model's `empty` class, and the largest reward for the others.
    seconds_per_tick : float, optional
        How long a tick lasts; reports use it.

    Raises
    ------
    ArgumentError
        For durations or prices that make no sense.
    ModelError
        For a model with keys that are not supported.

    Examples
    --------
    >>> import beltsort
    >>> model = beltsort.SortingModel(["nut", "bolt"], ["front"], [[[[0.8, 0.2], [0.2, 0.8]]]])
    >>> belt = beltsort.MovingBelt(model, ticks_per_place=4, seconds_per_tick=0.5)
    >>> belt.look_ticks.tolist(), belt.missed.tolist()
    ([[1]], [10.0, 10.0])
    >>> beltsort.MovingBelt.from_json(belt.to_json()) == belt
    True
    """

    def __new__(
        cls,
        model: SortingModel,
        *,
        ticks_per_place: int | None = None,
        advance_ticks: int | None = None,
        reach: int = 1,
        move_ticks: ArrayLike = 1,
        scan_ticks: int = 0,
        sort_ticks: int = 0,
        missed: Sequence[float] | NDArray[np.float64] | None = None,
        seconds_per_tick: float | None = None,
    ) -> MovingBelt: ...
    @staticmethod
    def load(path: str | PathLike[str]) -> MovingBelt:
        """Read the file of a moving belt.

        Parameters
        ----------
        path : str or os.PathLike
            A model file with one more key, ``moving_belt``: an object with the constructor's keywords.

        Returns
        -------
        MovingBelt
            The belt.

        Raises
        ------
        ModelError
            If the file cannot be read, is not JSON, has an unknown key, or lacks one.
        ArgumentError
            As the constructor.
        """
    @staticmethod
    def from_json(text: str) -> MovingBelt:
        """Read the text of the file of a moving belt.

        Parameters
        ----------
        text : str
            JSON.

        Returns
        -------
        MovingBelt
            The belt.

        Raises
        ------
        ModelError, ArgumentError
            As `load`.
        """
    def to_json(self) -> str:
        """Return the file as text, JSON."""
    def save(self, path: str | PathLike[str]) -> None:
        """Write the file; `load` gives an equal belt back.

        Parameters
        ----------
        path : str or os.PathLike
            Where to write; an existing file is replaced.

        Raises
        ------
        ModelError
            If the file cannot be written.
        """
    def belief(self, objects: int | None = None) -> MovingBelief:
        """Return the belief of a belt full of unseen objects that has just advanced.

        Parameters
        ----------
        objects : int, optional
            How many objects will pass, those at the places included; if missing, the belt never ends.

        Returns
        -------
        MovingBelief
            The belief.

        Raises
        ------
        ArgumentError
            For a negative number.
        """
    @property
    def model(self) -> SortingModel:
        """The model: classes, tables and rewards."""
    @property
    def ticks_per_place(self) -> int | None:
        """Ticks between two advances; None if the belt advances on decisions."""
    @property
    def advance_ticks(self) -> int | None:
        """Ticks of a decision and the advance after it; None for a belt of constant speed."""
    @property
    def reach(self) -> int:
        """Places, from the exit, at which objects can be decided."""
    @property
    def look_ticks(self) -> NDArray[np.uint64]:
        """Ticks of each look, its move and its scan; uint64 of shape (K, K), ``[start, end]``."""
    @property
    def decision_ticks(self) -> int:
        """Ticks of a decision: `sort_ticks`, or those of the advance."""
    @property
    def missed(self) -> NDArray[np.float64]:
        """Price of an object that passes the exit undecided, float64 of shape (L,)."""
    @property
    def seconds_per_tick(self) -> float | None:
        """How long a tick lasts, in seconds, or None."""
    @property
    def settings(self) -> dict[str, Any]:
        """What the belt was made with besides the model, as keywords of the constructor."""
    def __eq__(self, other: object) -> bool: ...
    def __ne__(self, other: object) -> bool: ...
    def __copy__(self) -> MovingBelt: ...
    def __deepcopy__(self, _memo: Any) -> MovingBelt: ...
    def __getnewargs_ex__(self) -> tuple[tuple[SortingModel], dict[str, Any]]: ...

@final
class MovingBelief:
    """What is known of the objects on a moving belt, and its clock.

    Each label depends on its own object only, and everything but the kinds (class and mode) is known, so the
    product of the rows is the exact posterior. It changes in place; `copy` it to keep one.

    Parameters
    ----------
    belt : MovingBelt
        Gives shape, tables, arrival prior and durations.
    kinds : array_like, shape (H, L) or (H, N), optional
        One distribution over the classes, or the kinds, per place, the one nearest to the exit first; the
        arrival prior at every place if missing.
    decided : sequence of H bools, optional
        Whether the object at each place is decided already, or there is none; none is if missing.
    offset : int, default 0
        Ticks since the belt last advanced, below `ticks_per_place`.
    to_come : int, optional
        Objects that have not come to a place yet; if missing, the belt never ends.

    Raises
    ------
    ArgumentError
        For another shape, a row that is no distribution, or numbers out of range.

    References
    ----------
    Mezei, Tamás & Buşoniu, ECC 2019, eq. 7 (`observe`) and eq. 8 (`advance_time`).

    Examples
    --------
    >>> import beltsort
    >>> model = beltsort.SortingModel(["nut", "bolt"], ["front"], [[[[0.8, 0.2], [0.2, 0.8]]]])
    >>> belt = beltsort.MovingBelt(model, ticks_per_place=4)
    >>> belief = belt.belief(objects=3)
    >>> belief.advance_time(1)
    0.0
    >>> belief.observe("front", ["bolt"])
    >>> belief
    MovingBelief([[0.200, 0.800]], decided=[False], offset=1, to_come=2)
    """

    def __new__(
        cls,
        belt: MovingBelt,
        *,
        kinds: ArrayLike | None = None,
        decided: Sequence[bool] | None = None,
        offset: int = 0,
        to_come: int | None = None,
    ) -> MovingBelief: ...
    @property
    def belt(self) -> MovingBelt:
        """The belt that this belief was made for."""
    @property
    def probabilities(self) -> NDArray[np.float64]:
        """Probability that the object at place j is of class i, float64 of shape (H, L); a copy."""
    @property
    def kinds(self) -> NDArray[np.float64]:
        """Probability that the object at place j is of kind n, float64 of shape (H, N); a copy."""
    @property
    def decided(self) -> list[bool]:
        """Whether the object at each place is decided, or there is none; list of length H."""
    @property
    def offset(self) -> int:
        """Ticks since the belt last advanced; since the last decision if it advances on decisions."""
    @property
    def to_come(self) -> int | None:
        """Objects that have not come to a place yet; None for a belt that never ends."""
    @property
    def is_over(self) -> bool:
        """Whether nothing is left to decide, now or later."""
    def ticks_left(self, position: int) -> int | None:
        """Return the ticks until the object at a place passes the exit.

        Parameters
        ----------
        position : int
            Index of the place, 0 nearest to the exit.

        Returns
        -------
        int or None
            At least 1; None if the belt advances on decisions.

        Raises
        ------
        ArgumentError
            If there is no such place.
        """
    def most_likely(self, position: int) -> tuple[int, float]:
        """Return the most likely class at a place (the lowest label among equals) and its probability.

        Parameters
        ----------
        position : int
            Index of the place, 0 nearest to the exit.

        Returns
        -------
        label : int
            Index of the class.
        probability : float
            Its probability.

        Raises
        ------
        ArgumentError
            If there is no such place.
        """
    def best_decision(self, position: int) -> tuple[int, float]:
        """Return the bin where the object at a place is worth most, and the expected reward.

        Parameters
        ----------
        position : int
            Index of the place, 0 nearest to the exit.

        Returns
        -------
        label : int
            Index of the bin.
        reward : float
            Expected reward of putting the object there.

        Raises
        ------
        ArgumentError
            If there is no such place.
        """
    def observe(self, viewpoint: int | str, labels: Sequence[int | str | None]) -> None:
        """Update the belief by the labels of one scan, with Bayes' rule.

        Parameters
        ----------
        viewpoint : int or str
            Index or name of the viewpoint that the scan was taken from.
        labels : sequence of int, str or None, length H
            The label of each place, index or name, the one nearest to the exit first; None where nothing was
            seen. Labels of decided objects are ignored.

        Raises
        ------
        ArgumentError
            For another number of labels, or a label or viewpoint that the model has not.
        ImpossibleObservationError
            For a label of probability 0. The belief is then unchanged.
        """
    def decide(self, position: int) -> None:
        """Mark the object at a place as decided.

        It stays where it is, unless the belt advances on decisions: then all that is known moves on by one
        place. Let the belt's `decision_ticks` pass afterwards.

        Parameters
        ----------
        position : int
            Index of the place, 0 nearest to the exit.

        Raises
        ------
        ArgumentError
            If it is out of reach, or decided already. The belief is then unchanged.
        """
    def advance_time(self, ticks: int) -> float:
        """Let time pass.

        At each advance of the belt every place takes over what is known of the one behind it, and the last
        one the arrival prior.

        Parameters
        ----------
        ticks : int
            How many ticks pass.

        Returns
        -------
        float
            Expected price of the objects that passed the exit undecided, discounted to the beginning.

        Raises
        ------
        ArgumentError
            For a negative number, or more than 4,294,967,295.
        """
    def copy(self) -> MovingBelief:
        """Return an independent belief, equal to this one."""
    def __eq__(self, other: object) -> bool: ...
    def __ne__(self, other: object) -> bool: ...
    def __copy__(self) -> MovingBelief: ...
    def __deepcopy__(self, _memo: Any) -> MovingBelief: ...
    def __reduce__(self) -> tuple[Any, Any]: ...
    __hash__: None  # type: ignore[assignment]

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

@final
class MovingEvaluation:
    """Outcomes of simulated runs of a moving belt: arrays of shape (runs,), in the order of the runs.

    Two policies that were evaluated with the same seed met the same objects: compare them run by run.
    """

    @property
    def belt(self) -> MovingBelt:
        """The belt that was simulated."""
    @property
    def objects(self) -> int:
        """Objects of each run."""
    @property
    def ticks(self) -> NDArray[np.uint64]:
        """Ticks until the action ended in which the last object was decided or passed the exit; uint64."""
    @property
    def looks(self) -> NDArray[np.uint64]:
        """Looks at undecided objects; uint64. A scan of two of them counts twice."""
    @property
    def right(self) -> NDArray[np.uint64]:
        """Right decisions, into a bin than which none is worth more for the object's class; uint64."""
    @property
    def wrong(self) -> NDArray[np.uint64]:
        """Other decisions; uint64."""
    @property
    def missed(self) -> NDArray[np.uint64]:
        """Objects that passed the exit undecided, by true class; uint64 of shape (runs, L)."""
    @property
    def confusion(self) -> NDArray[np.uint64]:
        """Decided objects by bin and true class, uint64 of shape (runs, B, L), ``[run, bin, class]``."""
    @property
    def returns(self) -> NDArray[np.float64]:
        """Sum of rewards; float64."""
    @property
    def discounted_returns(self) -> NDArray[np.float64]:
        """Sum of rewards, each times `discount` to the power of its tick; float64."""
    def statistics(self) -> MovingStatistics:
        """Return estimates over the runs, each with its standard error.

        Returns
        -------
        planning.moving.MovingStatistics
            Reward per object, discounted return, shares of right, wrong and missed objects, purity and
            recovery per bin, looks per object, ticks, and objects per minute.
        """
    def __copy__(self) -> MovingEvaluation: ...
    def __deepcopy__(self, _memo: Any) -> MovingEvaluation: ...
    def __reduce__(self) -> tuple[Any, Any]: ...

def evaluate_moving(
    belt: MovingBelt,
    policy: MovingPolicy,
    *,
    objects: int = ...,
    runs: int = ...,
    seed: int = 0,
    threads: int | None = None,
    viewpoint: int | str = 0,
) -> MovingEvaluation:
    """Simulate runs of a moving belt.

    Randoms are indexed by (run, object, look): every policy meets the same objects, and the n-th look at an
    object draws on the same random. A run starts with a belt full of unseen objects that has just advanced,
    and ends once its last object is decided or has passed the exit.

    Parameters
    ----------
    belt : MovingBelt
        Draws classes and labels, updates the belief, and gives rewards and durations.
    policy : MovingPolicy
        `MovingPlanner`, `MovingThreshold`, or any object with a method ``act(belief, viewpoint)`` that
        returns a `Move`, a `Wait` or a `DecideAt`. Such an object is asked from one thread, and its
        exceptions pass through unchanged.
    objects : int, default 50
        Objects of a run.
    runs : int, default 100
        Number of runs. Standard errors shrink with its square root only.
    seed : int
        Seed of classes and labels. A seed that a policy was tuned on flatters it.
    threads : int, optional
        Threads to use; all cores if missing.
    viewpoint : int or str
        Where the camera stands when a run starts.

    Returns
    -------
    MovingEvaluation
        One outcome per run.

    Raises
    ------
    ArgumentError
        For a count below 1, or a viewpoint that does not exist.
    PolicyError
        If the policy names no legal action, or decides nothing for 10,000 ticks on a belt that waits for it.

    Examples
    --------
    >>> import beltsort
    >>> model = beltsort.SortingModel(["nut", "bolt"], ["front"], [[[[1.0, 0.0], [0.0, 1.0]]]])
    >>> belt = beltsort.MovingBelt(model, ticks_per_place=4)
    >>> result = beltsort.evaluate_moving(belt, beltsort.MovingThreshold(belt, 0.9), objects=10, runs=3)
    >>> result.right
    array([10, 10, 10], dtype=uint64)
    >>> print(result.statistics().looks_per_object)
    1.000 ± 0.000
    """
