"""How much a policy loses at most, from a certified bound of the optimal value and simulated returns."""

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from statistics import NormalDist

import numpy as np

from beltsort._core import Belief, Evaluation, Solution
from beltsort.util.text import numbers_or_none, text_table

CONFIDENCE = 0.95
TITLE = "Loss against an optimal policy, discounted, on a belt that never ends (estimates ± standard error):"
EXPLANATION = (
    "Certified: the bound of the optimal value, and that of the rewards after a batch (discount^steps times\n"
    "the worst reward of every further step). Estimated from the batches: the return, and with it the loss."
)


@dataclass(frozen=True)
class LossBound:
    """An upper bound of V*(b0) - V(b0), what a policy of value V loses; estimated from independent batches.

    A batch gives ``optimal_value - return + discount**steps * worst``, where ``worst`` is what a policy loses
    if each step after the batch earns the least that a step can. Its expected value is an upper bound of the
    loss, however short batches are; with short ones it is loose.

    Attributes
    ----------
    optimal_value
        Certified upper bound of V*(b0), b0 the arrival prior at every position.
    expected_return
        Mean of `Evaluation.expected_discounted_returns`.
    tail
        Mean bound of what the rewards after a batch may take away, part of `mean`; longer batches make it
        smaller.
    mean
        Mean of the bound over batches.
    standard_error
        Standard error of `mean`; NaN for a single batch.
    """

    optimal_value: float
    expected_return: float
    tail: float
    mean: float
    standard_error: float

    @property
    def confidence_limit(self) -> float:
        """The loss lies below this limit with 95 % confidence (one-sided, by the normal distribution)."""
        return self.mean + NormalDist().inv_cdf(CONFIDENCE) * self.standard_error

    def to_dict(self) -> dict[str, float | None]:
        """Return the numbers as plain data for JSON; those that are not finite become None."""
        return numbers_or_none(asdict(self) | {"confidence_limit": self.confidence_limit})


def loss_bound(evaluation: Evaluation, reference: Solution, viewpoint: int | str = 0) -> LossBound:
    """Return how much an evaluated policy loses at most.

    Parameters
    ----------
    evaluation
        Of a policy, on objects and labels drawn from the model of `reference`, on a belt that never ends.
    reference
        A solution of the model.
    viewpoint
        Where the camera stood when the batches started.

    Raises
    ------
    ArgumentError
        If the objects or labels were not drawn from the model.
    """
    model = reference.model
    optimal_value = reference.bounds(Belief(model), viewpoint)[1]
    returns = evaluation.expected_discounted_returns
    worst_step = max(model.r_min, float(model.motion_cost.max()))
    tails = model.discount ** evaluation.steps.astype(np.float64) * worst_step / (1.0 - model.discount)
    losses = optimal_value - returns + tails
    n = len(losses)
    error = float(losses.std(ddof=1)) / math.sqrt(n) if n > 1 else math.nan
    return LossBound(optimal_value, float(returns.mean()), float(tails.mean()), float(losses.mean()), error)


def loss_bounds_table(bounds: Mapping[str, LossBound]) -> str:
    """Format the bounds of several policies as plain text, a column per policy."""
    rows = [
        ["", *bounds],
        ["optimal value at most (certified)", *(f"{bound.optimal_value:.3f}" for bound in bounds.values())],
        ["expected return", *(f"{bound.expected_return:.3f}" for bound in bounds.values())],
        ["rewards after a batch: loss at most", *(f"{bound.tail:.3f}" for bound in bounds.values())],
        ["loses at most", *(f"{bound.mean:.3f} ± {bound.standard_error:.3f}" for bound in bounds.values())],
        [
            f"upper {100 * CONFIDENCE:.0f} % confidence limit",
            *(f"{bound.confidence_limit:.3f}" for bound in bounds.values()),
        ],
    ]
    return "\n".join([TITLE, text_table(rows), EXPLANATION])
