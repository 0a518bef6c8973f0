from collections.abc import Callable
from os import PathLike
from typing import TypeAlias, final

from beltsort._stubs.actions import Decide, Move
from beltsort._stubs.belief import Belief
from beltsort._stubs.model import SortingModel

_Path: TypeAlias = str | PathLike[str]

@final
class Solution:
    """Certified bounds of the optimal value, and a policy: what `solve` returns.

    References
    ----------
    Upper bound: value iteration on a grid of beliefs, convex in the belief about each object (Lovejoy,
    Operations Research 39, 1991). Search and lower bound: a graph of the beliefs reached, whose policy is
    valued exactly, as finite-state controllers are (Hansen, UAI 1998).
    """

    @property
    def lower(self) -> float:
        """Lower bound of V*(b0), the value of an executable policy; b0 is the arrival prior everywhere."""
    @property
    def upper(self) -> float:
        """Upper bound of V*(b0)."""
    @property
    def seconds(self) -> float:
        """Wall-clock time spent, seconds."""
    @property
    def model(self) -> SortingModel:
        """The model solved."""
    @property
    def values_actions(self) -> bool:
        """Whether it tells what single actions lose, as `evaluate` needs of a reference.

        It does for one or two positions whose viewpoints all have the same moves at the same costs.
        """
    def check_solves(self, model: SortingModel) -> None:
        """Check that this is a solution of a model; remarks and label counts may differ.

        Parameters
        ----------
        model : SortingModel
            The model.

        Raises
        ------
        ArgumentError
            If it solves another model; the first difference is named.
        """
    def bounds(self, belief: Belief, viewpoint: int | str = 0) -> tuple[float, float]:
        """Return bounds of V* at any belief.

        At the arrival prior they are those of the search, elsewhere wider.

        Parameters
        ----------
        belief : Belief
            What is known of the objects.
        viewpoint : int or str
            Where the camera stands: index or name.

        Returns
        -------
        tuple of float
            Lower and upper bound.

        Raises
        ------
        ArgumentError
            For a belief of another model or an unknown viewpoint.
        """
    def act(self, belief: Belief, viewpoint: int | str) -> Move | Decide:
        """Return the action that is best one exact step ahead of the upper bound: a solution is a policy.

        Parameters
        ----------
        belief : Belief
            What is known of the objects.
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
    def save(self, path: _Path) -> None:
        """Write the solution to disk, up to 40 MB; `load` reads it.

        Parameters
        ----------
        path : str or os.PathLike
            Where to write; an existing file is replaced as a whole or not at all.

        Raises
        ------
        ArgumentError
            If the file cannot be written.

        Examples
        --------
        >>> import beltsort, pathlib, tempfile
        >>> model = beltsort.SortingModel(["nut", "bolt"], ["front"], [[[[0.8, 0.2], [0.2, 0.8]]]])
        >>> path = pathlib.Path(tempfile.mkdtemp()) / "nuts.solution"
        >>> beltsort.solve(model, seconds=0.2).save(path)
        >>> beltsort.Solution.load(path, model).act(beltsort.Belief(model), 0)
        Move(viewpoint=0)
        """
    @staticmethod
    def load(path: _Path, model: SortingModel | None = None) -> Solution:
        """Read a solution from disk; it answers like the one that was saved.

        Parameters
        ----------
        path : str or os.PathLike
            A file written by `save`, or by ``beltsort solve MODEL -o FILE``.
        model : SortingModel, optional
            The model that it has to be a solution of; remarks and label counts may differ.

        Returns
        -------
        Solution
            The solution.

        Raises
        ------
        ArgumentError
            If the file cannot be read, is damaged or of another version, or solves another model than the one
            given; the first difference is named.
        """
    def _repr_html_(self) -> str:
        """Return HTML for notebooks."""
    def __copy__(self) -> Solution: ...
    def __deepcopy__(self, _memo: object) -> Solution: ...

def solve(
    model: SortingModel,
    *,
    seconds: float = ...,
    progress: Callable[[float, float], object] | None = None,
    stop: Callable[[], object] | None = None,
) -> Solution:
    """Solve a model offline, with a certificate: ``lower <= V*(b0) <= upper``.

    Both bounds hold whenever it ends. They are tight for one or two positions when all viewpoints have the
    same moves at the same costs. For other models, of any size, the upper bound is a Lagrangian relaxation:
    each position has a camera of its own, and prices make them agree. The lower bound is then what following
    one-object plans earns, which may be far below.

    Parameters
    ----------
    model : SortingModel
        The paper's, without `repeat`, `observe_after_decision` and `information_gain`. Where a scan has more
        than 4096 label vectors (L^H), they are not searched.
    seconds : float, default 60
        Wall-clock time; more brings the bounds together. It ends earlier once they meet, and on Ctrl-C with
        KeyboardInterrupt.
    progress : callable, optional
        Called with the bounds ``(lower, upper)`` so far, from another thread. What it raises ends the solver
        and passes through.
    stop : callable, optional
        Called without arguments some twenty times a second; once it returns true, the solver ends and returns
        what it has: both bounds hold. What it raises passes through.

    Returns
    -------
    Solution
        The bounds, and a policy.

    Raises
    ------
    ArgumentError
        For a time that is not above 0.
    ModelError
        For a model beyond the paper's.

    References
    ----------
    Adelman & Mersereau, "Relaxations of weakly coupled stochastic dynamic programs", Operations Research 56,
    2008.

    Examples
    --------
    >>> import beltsort
    >>> model = beltsort.SortingModel(["nut", "bolt"], ["front"], [[[[0.8, 0.2], [0.2, 0.8]]]])
    >>> solution = beltsort.solve(model, seconds=5)
    >>> f"{solution.lower:.2f} {solution.upper:.2f}"
    '15.77 15.77'
    """
