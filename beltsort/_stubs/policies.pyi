from typing import Any, Literal, final

from beltsort._stubs.actions import Decide, Move
from beltsort._stubs.belief import Belief
from beltsort._stubs.model import SortingModel

@final
class Threshold:
    """Look from one viewpoint until the best decision is likely enough to be right.

    The best decision is the one with the largest expected reward; it is right if no bin is worth more for the
    object's class. Where the bins are the classes, it is the most likely class. A manual bin, which is right
    for no class, is never chosen while a move is legal.

    Parameters
    ----------
    model : SortingModel
        The problem.
    threshold : float
        Decide once the best decision at the belt end is right with this probability, above 0 and at most 1.
        Too near 1, and no decision may ever be reached: `max_looks` of `evaluate` then forces one.
    viewpoint : int or str, optional
        Index or name of the viewpoint to look from, reached by the fewest moves; if missing, the one whose
        scan tells most about an object that has just arrived.

    Raises
    ------
    ArgumentError
        For a threshold outside (0, 1] or an unknown viewpoint.

    Examples
    --------
    >>> import beltsort
    >>> model = beltsort.SortingModel(["nut", "bolt"], ["front"], [[[[0.8, 0.2], [0.2, 0.8]]]])
    >>> policy = beltsort.Threshold(model, 0.75)
    >>> policy.act(beltsort.Belief(model, [[0.25, 0.75]]), 0)
    Decide(label=1)
    """

    def __new__(
        cls, model: SortingModel, threshold: float, viewpoint: int | str | None = None
    ) -> Threshold: ...
    @property
    def settings(self) -> dict[str, Any]:
        """What the policy was made with, as keywords of the constructor: threshold, viewpoint."""
    @property
    def model(self) -> SortingModel:
        """The model that the policy was made for."""
    def act(self, belief: Belief, viewpoint: int | str) -> Move | Decide:
        """Decide at the threshold, move below it.

        Parameters
        ----------
        belief : Belief
            What is known of the objects; made for the policy's model, or an equal one.
        viewpoint : int or str
            Where the camera stands: index or name.

        Returns
        -------
        Move or Decide
            The action; a decision too where no move is legal.

        Raises
        ------
        ArgumentError
            For a belief of another model or an unknown viewpoint.
        """
    def _repr_html_(self) -> str:
        """Return HTML for notebooks."""
    def __copy__(self) -> Threshold: ...
    def __deepcopy__(self, _memo: object) -> Threshold: ...
    def __getnewargs_ex__(self) -> tuple[tuple[SortingModel], dict[str, Any]]: ...

@final
class InformationGain:
    """Look from where most is learnt until the best decision is likely enough to be right.

    Decisions are those of `Threshold`.

    Parameters
    ----------
    model : SortingModel
        The problem.
    threshold : float
        As for `Threshold`.
    positions : int, default 1
        The gain of a look is the expected drop of an entropy, summed over this many positions from the belt
        end, 1 to H. With many, objects far from their decision outvote the one at the belt end.
    about : {"class", "bin"}, default "class"
        What the entropy is of: the object's class, or the bin where it belongs, so that classes with the same
        right bins are not told apart. In the paper's model both are the same.

    Raises
    ------
    ArgumentError
        For a threshold outside (0, 1], positions outside 1 to H, or another word.

    Examples
    --------
    >>> import beltsort
    >>> blind, sharp = [[0.5, 0.5], [0.5, 0.5]], [[0.9, 0.1], [0.1, 0.9]]
    >>> model = beltsort.SortingModel(["nut", "bolt"], ["below", "front"], [[blind, sharp]])
    >>> beltsort.InformationGain(model, 0.95).act(beltsort.Belief(model), 0)
    Move(viewpoint=1)
    """

    def __new__(
        cls,
        model: SortingModel,
        threshold: float,
        positions: int = ...,
        *,
        about: Literal["class", "bin"] = "class",
    ) -> InformationGain: ...
    @property
    def settings(self) -> dict[str, Any]:
        """What the policy was made with, as keywords of the constructor: threshold, positions, about."""
    @property
    def model(self) -> SortingModel:
        """The model that the policy was made for."""
    def act(self, belief: Belief, viewpoint: int | str) -> Move | Decide:
        """Decide at the threshold, move below it.

        Parameters
        ----------
        belief : Belief
            What is known of the objects; made for the policy's model, or an equal one.
        viewpoint : int or str
            Where the camera stands: index or name.

        Returns
        -------
        Move or Decide
            The action; a decision too where no move is legal.

        Raises
        ------
        ArgumentError
            For a belief of another model or an unknown viewpoint.
        """
    def _repr_html_(self) -> str:
        """Return HTML for notebooks."""
    def __copy__(self) -> InformationGain: ...
    def __deepcopy__(self, _memo: object) -> InformationGain: ...
    def __getnewargs_ex__(self) -> tuple[tuple[SortingModel], dict[str, Any]]: ...

@final
class LookAhead:
    """Compare all actions a fixed number of steps ahead, with the leaf values of `Despot`.

    A baseline for the search: no trials, no bounds. Labels that no scenario gives follow the one-object
    policy.

    Parameters
    ----------
    model : SortingModel
        The problem; its one-object plans are found here, which takes a moment.
    depth : int, default 1
        Planner steps to look ahead, 1 to 4. The tree grows with the power of it.
    scenarios : int, default 500
        As for `Despot`.
    seed : int
        As for `Despot`.

    Raises
    ------
    ArgumentError
        For another depth, or no scenarios.

    Examples
    --------
    >>> import beltsort
    >>> model = beltsort.SortingModel(["nut", "bolt"], ["front"], [[[[0.8, 0.2], [0.2, 0.8]]]])
    >>> beltsort.LookAhead(model, depth=2).act(beltsort.Belief(model), 0)
    Move(viewpoint=0)
    """

    def __new__(
        cls, model: SortingModel, depth: int = ..., *, scenarios: int = ..., seed: int = 0
    ) -> LookAhead: ...
    @property
    def settings(self) -> dict[str, Any]:
        """What the policy was made with, as keywords of the constructor: depth, scenarios, seed."""
    @property
    def model(self) -> SortingModel:
        """The model that the policy was made for."""
    def act(self, belief: Belief, viewpoint: int | str) -> Move | Decide:
        """Return the action with the highest value.

        Parameters
        ----------
        belief : Belief
            What is known of the objects; made for the policy's model, or an equal one.
        viewpoint : int or str
            Where the camera stands: index or name.

        Returns
        -------
        Move or Decide
            The action.

        Raises
        ------
        ArgumentError
            For a belief of another model or an unknown viewpoint.
        """
    def _repr_html_(self) -> str:
        """Return HTML for notebooks."""
    def __copy__(self) -> LookAhead: ...
    def __deepcopy__(self, _memo: object) -> LookAhead: ...
    def __getnewargs_ex__(self) -> tuple[tuple[SortingModel], dict[str, Any]]: ...

@final
class OneObject:
    """Follow the best conditional plan for the object at the belt end, chosen anew at each step.

    The default policy of `Despot`. Each plan looks at one object until it pays to decide; what its looks tell
    about the objects behind is used once their turn comes. Labels are taken as independent, and a bonus for
    information is left aside.

    Parameters
    ----------
    model : SortingModel
        The problem; its one-object plans are found here, which takes a moment.

    References
    ----------
    Point-based value iteration: Pineau, Gordon & Thrun, IJCAI 2003.

    Examples
    --------
    >>> import beltsort
    >>> model = beltsort.SortingModel(["nut", "bolt"], ["front"], [[[[0.8, 0.2], [0.2, 0.8]]]])
    >>> beltsort.OneObject(model).act(beltsort.Belief(model), 0)
    Move(viewpoint=0)
    """

    def __new__(cls, model: SortingModel) -> OneObject: ...
    @property
    def model(self) -> SortingModel:
        """The model that the policy was made for."""
    def act(self, belief: Belief, viewpoint: int | str) -> Move | Decide:
        """Return the first action of the best plan.

        Parameters
        ----------
        belief : Belief
            What is known of the objects; made for the policy's model, or an equal one.
        viewpoint : int or str
            Where the camera stands: index or name.

        Returns
        -------
        Move or Decide
            The action.

        Raises
        ------
        ArgumentError
            For a belief of another model or an unknown viewpoint.
        """
    def _repr_html_(self) -> str:
        """Return HTML for notebooks."""
    def __copy__(self) -> OneObject: ...
    def __deepcopy__(self, _memo: object) -> OneObject: ...
    def __getnewargs__(self) -> tuple[SortingModel]: ...
