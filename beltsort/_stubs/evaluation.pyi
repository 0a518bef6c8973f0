from typing import final

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from beltsort._stubs.model import SortingModel
from beltsort._stubs.solution import Solution
from beltsort.planning.policy import Policy

@final
class Evaluation:
    """Outcomes of simulated batches: arrays of shape (batches,), in the order of the batches.

    Rewards are in the unit of `r_max` and `r_min`. Two policies that were evaluated with the same seed met
    the same objects: compare them batch by batch.
    """

    @property
    def steps(self) -> NDArray[np.uint64]:
        """Planner steps, that is moves and decisions; uint64."""
    @property
    def correct(self) -> NDArray[np.uint64]:
        """Right decisions; uint64, at most `batch_size`.

        A decision is right if no bin is worth more for the object's class.
        """
    @property
    def confusion(self) -> NDArray[np.uint64]:
        """Confusion matrices of the decisions, uint64 of shape (batches, B, L), ``[batch, bin, class]``.

        Objects by bin and true class.
        """
    @property
    def forced(self) -> NDArray[np.uint64]:
        """Decisions forced by `max_looks`, or by three impossible labels of one object in a row; uint64."""
    @property
    def returns(self) -> NDArray[np.float64]:
        """Sum of rewards; float64."""
    @property
    def discounted_returns(self) -> NDArray[np.float64]:
        """Sum of rewards, each times `discount` to the power of the planner steps before it; float64."""
    @property
    def expected_discounted_returns(self) -> NDArray[np.float64]:
        """As `discounted_returns`, each decision scored by its expected reward under the belief; float64.

        The same mean and a far smaller variance, as long as the model itself draws classes and labels.

        Raises
        ------
        ArgumentError
            If `true_classes` or another `truth` was given: the mean would be biased.
        """
    @property
    def bonuses(self) -> NDArray[np.float64]:
        """Sum of the bonuses for information; float64. No other property contains them.

        A bonus is `information_gain` times the expected entropy reduction of a scan.
        """
    @property
    def discounted_bonuses(self) -> NDArray[np.float64]:
        """Sum of discounted bonuses; float64."""
    @property
    def regrets(self) -> NDArray[np.float64]:
        """Sum of what the policy's actions lost against the best ones; float64.

        Raises
        ------
        ArgumentError
            If no `reference` was given.
        """
    @property
    def discounted_regrets(self) -> NDArray[np.float64]:
        """Sum of discounted regrets; float64.

        Over batches so long that nothing is left behind them, its mean is what the policy's value falls short
        of the reference's.

        Raises
        ------
        ArgumentError
            If no `reference` was given.
        """
    def summary(self) -> dict[str, dict[str, float]]:
        """Return mean and standard error over the batches of every outcome.

        Returns
        -------
        dict
            For each property above, a dict with the keys ``mean`` and ``standard_error`` (NaN for a single
            batch). `expected_discounted_returns` is left out where it would be biased, bonuses where the
            model's `information_gain` is 0, regrets without a `reference`.
        """
    def to_pandas(self) -> pd.DataFrame:
        """Return the outcomes as a table with a row per batch.

        Returns
        -------
        pandas.DataFrame
            The columns are the properties that `summary` lists, the index is the number of the batch.

        Raises
        ------
        MissingExtraError
            If pandas is not installed.
        """
    def _repr_html_(self) -> str:
        """Return HTML for notebooks."""
    def __copy__(self) -> Evaluation: ...
    def __deepcopy__(self, _memo: object) -> Evaluation: ...

def evaluate(
    model: SortingModel,
    policy: Policy,
    *,
    batches: int = ...,
    batch_size: int = ...,
    seed: int = 0,
    threads: int | None = None,
    viewpoint: int | str = 0,
    true_classes: ArrayLike | None = None,
    truth: SortingModel | None = None,
    max_looks: int = ...,
    reference: Solution | None = None,
    belt_ends: bool = False,
) -> Evaluation:
    """Simulate batches of the sorting POMDP.

    Randoms are indexed by (batch, object, look): every policy meets the same objects, and the n-th look at an
    object draws on the same random. The result depends on neither `threads` nor the machine, unless the
    policy does (a planner with a time budget does).

    Parameters
    ----------
    model : SortingModel
        Updates the belief, gives the rewards, and says whether a scan follows each decision. Such a scan
        counts for `max_looks`, but is no step.
    policy : Policy
        `Despot`, `LookAhead`, `Threshold`, `InformationGain`, `OneObject`, or any object with a method
        ``act(belief, viewpoint)`` that
        returns a `Move` or a `Decide`. Such an object is asked from one thread, and its exceptions pass
        through unchanged.
    batches : int, default 1000
        Number of batches. Standard errors shrink with its square root only.
    batch_size : int, default 10
        Decisions per batch; each batch starts from the arrival prior.
    seed : int
        Seed of classes and labels. A seed that a policy was tuned on flatters it.
    threads : int, optional
        Threads to use; all cores if missing. More than that gain nothing.
    viewpoint : int or str
        Where the camera stands when a batch starts.
    true_classes : array_like of int or str, optional
        A list of classes to draw from uniformly, or the class of every object, shape (batches, batch_size + H
        - 1). The arrival prior of `truth` if missing.
    truth : SortingModel, optional
        Draws classes and labels, repeated ones by its own `repeat`; `model` if missing. Its H, K and L must
        be those of `model`.
    max_looks : int, default 60
        An object looked at this often gets the decision with the largest expected reward. Too large, and a
        policy that never decides never ends.
    reference : Solution, optional
        What the actions are held against: its upper bound, one exact step ahead, says what each of them loses
        (`Evaluation.regrets`). For one or two positions, viewpoints that are all alike
        (`Solution.values_actions`), and belts that never end.
    belt_ends : bool
        Whether the belt ends with the batch, and the beliefs that the policy is asked with tell how many
        objects are left (`Belief.remaining`); `Despot`, `LookAhead` and `OneObject` take it into account.

    Returns
    -------
    Evaluation
        One outcome per batch.

    Raises
    ------
    ArgumentError
        For a count below 1, or an argument that does not fit the model.
    PolicyError
        If the policy names no legal action.

    Examples
    --------
    >>> import beltsort
    >>> model = beltsort.SortingModel(["nut", "bolt"], ["front"], [[[[1.0, 0.0], [0.0, 1.0]]]])
    >>> result = beltsort.evaluate(model, beltsort.Threshold(model, 0.9), batches=3)
    >>> result.correct
    array([10, 10, 10], dtype=uint64)
    >>> result.summary()["steps"]
    {'mean': 20.0, 'standard_error': 0.0}
    """
