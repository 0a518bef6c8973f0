"""What a model promises before the first object is sorted, and what would help if that is little."""

from collections.abc import Iterator
from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import ArrayLike

from beltsort._core import DEFAULT_MAX_LOOKS, Evaluation, OneObject, SortingModel, evaluate
from beltsort.planning.model_changes import changed_models
from beltsort.planning.separation import (
    Separation,
    entropy_left,
    independent_looks,
    worst_separation,
)
from beltsort.util.text import number_or_none, position_number

BATCHES = 50
BATCH_SIZE = 10
LOOKS = 12
"""Looks after which dependent looks are compared with independent ones."""

MOST_FORCED = 0.02
"""Share of forced decisions above which looking does not end by itself.

At the default `max_looks`, the paper's model has 0.000 at r_min of 5, 50 and 500, as do the simulated cell's
tables. Tables of real scans that repeat their labels (docs/calibration.md) have 0.06 to 0.98 at 40 looks.
"""

REPEATED = 0.1
"""Looks repeat if `LOOKS` of them leave more of the prior entropy than independent ones, by more than this.

The simulated cell, where a second look repeats the first with probability 0.08 to 0.28, has 0.01. The paper's
model has 0.08 with `repeat` at 0.5, 0.23 at 0.9. Real scans with 0.84 to 1.00 have 0.24 (sticky labels) to
0.32 (`repeat`).
"""


@dataclass(frozen=True)
class Mean:
    """A mean over simulated batches, per object, and its standard error."""

    mean: float
    error: float

    def __str__(self) -> str:
        """Return both as text."""
        return f"{self.mean:.2f} ± {self.error:.2f}"


@dataclass(frozen=True)
class Simulated:
    """What a simulated policy reaches, per object.

    Attributes
    ----------
    looks
        Scans. One scan sees all positions, so this is less than the looks at one object.
    right
        Share of objects in a bin than which none is worth more for their class.
    forced
        Share of decisions that the limit on looks forced.
    reward
        Rewards of decisions minus costs of moves, not discounted.
    """

    looks: Mean
    right: Mean
    forced: Mean
    reward: Mean

    def __str__(self) -> str:
        """Return the numbers as text."""
        return (
            f"{self.looks} scans, {self.right} right, {self.forced} forced by max_looks, reward {self.reward}"
        )


@dataclass(frozen=True)
class Remedy:
    """A change of the model, and what the policy reaches with it.

    Attributes
    ----------
    change
        What is changed, in words.
    simulated
        With the changed model.
    """

    change: str
    simulated: Simulated

    def __str__(self) -> str:
        """Return a line of text."""
        return f"{self.change}: {self.simulated}"


@dataclass(frozen=True)
class Expectation:
    """What a model promises.

    Attributes
    ----------
    simulated
        With the one-object policy, on objects and labels drawn from the model.
    max_looks
        Looks at one object after which a decision is forced.
    worst
        The pair of classes told apart worst; None if there is nothing to tell apart.
    left, left_if_independent
        Share of the prior entropy of a class left after `LOOKS` looks, and what it would be if looks were
        independent given the class.
    warnings
        What is wrong, in sentences.
    remedies
        What would help, the highest reward first; empty without a warning.
    """

    simulated: Simulated
    max_looks: int
    worst: Separation | None
    left: float
    left_if_independent: float
    warnings: tuple[str, ...]
    remedies: tuple[Remedy, ...]

    def to_dict(self) -> dict[str, object]:
        """Return everything as plain data for JSON."""
        plain = asdict(self)
        if self.worst is not None:  # without a common label, the information is infinite
            plain["worst"]["information"] = number_or_none(self.worst.information)
        return plain

    def __str__(self) -> str:
        """Return a short paragraph."""
        lines = [f"Expected, per object, by simulation of the model: {self.simulated}."]
        if (worst := self.worst) is not None:
            number = "no number of" if worst.looks is None else f"about {worst.looks:.0f} independent"
            lines.append(
                f"Told apart worst: {' and '.join(worst.classes)}, by {number} looks from {worst.viewpoint} "
                f"at position {position_number(worst.position)} ({worst.information:.3f} nats each)."
            )
        lines += [f"Warning: {warning}." for warning in self.warnings]
        lines += [f"What would help: {remedy}." for remedy in self.remedies]
        return "\n".join(lines)


def expectation(model: SortingModel, *, max_looks: int = DEFAULT_MAX_LOOKS, seed: int = 0) -> Expectation:
    """Return what a model promises, and warn of a belt that cannot be sorted with it.

    The one-object policy is simulated, which takes the time to construct it and little more. It warns if

    - more than `MOST_FORCED` of the decisions are forced by `max_looks`,
    - sorting loses: the mean reward of an object, looks paid for, is below 0 by two standard errors,
    - two classes need more than `max_looks` looks to be told apart, or no number suffices,
    - looks repeat: `LOOKS` of them leave more of the entropy than independent ones, by more than `REPEATED`.

    With a warning, the same simulation tells what another viewpoint, a common bin of the two classes and a
    manual bin would bring.

    Parameters
    ----------
    model
        The model. What is promised is true as far as the model is.
    max_looks
        As in `beltsort.evaluate`.
    seed
        Of objects and labels.

    Raises
    ------
    ArgumentError
        If `max_looks` is below 1.

    Examples
    --------
    >>> from beltsort.models import paper
    >>> promised = expectation(paper())
    >>> promised.warnings, promised.worst.classes
    ((), ('mushroom', 'standard'))
    >>> chance = paper().replace(p_obs=np.full((2, 3, 4, 4), 0.25))
    >>> for warning in expectation(chance).warnings:
    ...     print(warning.split(":")[0])
    100% of the decisions are forced by max_looks = 60
    sorting loses
    elongated and livarno cannot be told apart
    """
    simulated = _simulated(model, max_looks, seed)
    worst = worst_separation(model)
    left = float(entropy_left(model, LOOKS, seed=seed)[-1])
    independent = float(entropy_left(independent_looks(model), LOOKS, seed=seed)[-1])
    warnings = tuple(_warnings(max_looks, simulated, worst, left, independent))
    remedies = []
    if warnings:
        changes = changed_models(model, worst)
        remedies = [Remedy(change, _simulated(changed, max_looks, seed)) for change, changed in changes]
        remedies = [each for each in remedies if each.simulated.reward.mean > simulated.reward.mean]
        remedies.sort(key=lambda each: -each.simulated.reward.mean)
    return Expectation(simulated, max_looks, worst, left, independent, warnings, tuple(remedies))


def _simulated(model: SortingModel, max_looks: int, seed: int) -> Simulated:
    result = evaluate(
        model,
        OneObject(model),
        batches=BATCHES,
        batch_size=BATCH_SIZE,
        seed=seed,
        threads=1,
        max_looks=max_looks,
    )
    return Simulated(
        _mean(result.steps.astype(np.float64) - BATCH_SIZE),
        _mean(result.correct),
        _mean(result.forced),
        _mean(_rewards(result)),
    )


def _rewards(result: Evaluation) -> ArrayLike:
    return result.returns - result.bonuses


def _mean(per_batch: ArrayLike) -> Mean:
    per_object = np.asarray(per_batch, dtype=np.float64) / BATCH_SIZE
    return Mean(float(per_object.mean()), float(per_object.std(ddof=1) / np.sqrt(BATCHES)))


def _warnings(
    max_looks: int,
    simulated: Simulated,
    worst: Separation | None,
    left: float,
    independent: float,
) -> Iterator[str]:
    if simulated.forced.mean > MOST_FORCED:
        yield (
            f"{simulated.forced.mean:.0%} of the decisions are forced by max_looks = {max_looks}: the "
            "policy would rather look on than decide"
        )
    if simulated.reward.mean + 2.0 * simulated.reward.error < 0.0:
        yield f"sorting loses: the reward of an object is {simulated.reward}, expected above 0"
    if worst is not None and (worst.looks is None or worst.looks > max_looks):
        number = "any number of" if worst.looks is None else f"about {worst.looks:.0f}"
        yield (
            f"{' and '.join(worst.classes)} cannot be told apart: {number} looks would be needed, max_looks "
            f"is {max_looks}"
        )
    if left - independent > REPEATED:
        yield (
            f"looks repeat each other: {LOOKS} looks leave {left:.0%} of the uncertainty about an object, "
            f"independent ones would leave {independent:.0%}"
        )
