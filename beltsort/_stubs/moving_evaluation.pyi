from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from beltsort._stubs.moving_belt import MovingBelt
from beltsort.planning.moving import MovingStatistics
from beltsort.planning.policy import MovingPolicy

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
