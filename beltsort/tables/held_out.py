"""How well fitted tables predict the class of objects that they were not fitted to.

Fit statistics of few looks cannot tell structures of dependence apart; held-out objects can.

References
----------
P. S. Albert, L. E. Dodd, "A cautionary note on the robustness of latent class models for estimating
diagnostic error without a gold standard", Biometrics 60 (2004).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

import beltsort
from beltsort.tables.modes import ModeTables
from beltsort.tables.repeated_looks import Array, Integers, RepeatedLooks
from beltsort.util.calibration_error import calibration_error
from beltsort.util.extras import extra

with extra("perception"):
    from scipy.special import logsumexp

STAGES = (1 / 3, 2 / 3, 1.0)
"""Shares of an object's looks after which its class is predicted: a run decides after few or many looks."""


class Fitted(Protocol):
    """Tables that say how likely labels are: `ModeTables`, `StickyLabels`."""

    @property
    def kinds(self) -> int:
        """Number of kinds that a belief about one object needs."""

    def log_likelihoods(self, looks: RepeatedLooks) -> Array:
        """Return the logarithm of the probability of each object's labels given each class, (n, L)."""

    def as_modes(self) -> ModeTables:
        """Return the same distribution as tables of kinds."""


@dataclass(frozen=True)
class Candidate:
    """A way to fit tables.

    Attributes
    ----------
    name
        In words, for example "2 modes".
    fit
        Fits tables to looks.
    """

    name: str
    fit: Callable[[RepeatedLooks], Fitted]


def log_posteriors(fitted: Fitted, looks: RepeatedLooks, arrival: ArrayLike | None = None) -> Array:
    """Return the logarithm of the probability of each class given each object's labels, shape (n, L).

    Parameters
    ----------
    fitted
        The tables.
    looks
        At the objects; their true classes are not used.
    arrival
        Probabilities of the classes before the first look, shape (L,); default all equal.

    Examples
    --------
    >>> from beltsort.tables.modes import fit_modes
    >>> from beltsort.tables.repeated_looks import LooksAtObject, TableShape
    >>> shape = TableShape(positions=1, viewpoints=1, classes=2, labels=2)
    >>> objects = [LooksAtObject(true=i % 2, looks=((0, 0, i % 2),)) for i in range(4)]
    >>> tables = fit_modes(RepeatedLooks.of(objects, shape), modes=1)
    >>> twice = RepeatedLooks.of([LooksAtObject(true=0, looks=((0, 0, 0), (0, 0, 0)))], shape)
    >>> np.exp(log_posteriors(tables, twice)).round(3).tolist()
    [[0.9, 0.1]]
    """
    joint = fitted.log_likelihoods(looks)
    if arrival is not None:
        joint = joint + np.log(np.asarray(arrival, dtype=np.float64))
    posterior: Array = joint - logsumexp(joint, axis=1, keepdims=True)
    return posterior


@dataclass(frozen=True, eq=False)
class Prediction:
    """Predicted classes of n objects after each of `STAGES`.

    Attributes
    ----------
    log_beliefs
        Logarithm of the probability of each class, shape (n, stages, L).
    true
        Class indices, shape (n,).
    """

    log_beliefs: Array
    true: Integers

    @property
    def losses(self) -> Array:
        """Log-loss of each object's true class, the mean over stages, nats, shape (n,)."""
        losses: Array = -self.log_beliefs[np.arange(len(self.true)), :, self.true].mean(axis=1)
        return losses

    @property
    def calibration_error(self) -> float:
        """Expected calibration error of the beliefs, the mean over stages."""
        beliefs = np.exp(self.log_beliefs).swapaxes(0, 1)
        return float(np.mean([calibration_error(each, self.true) for each in beliefs]))


def predict(fitted: Fitted, looks: RepeatedLooks) -> Prediction:
    """Predict the classes of objects after each of `STAGES`."""
    stages = [log_posteriors(fitted, looks.first(share)) for share in STAGES]
    return Prediction(np.stack(stages, axis=1), looks.true)


def cross_validated(
    candidate: Candidate,
    looks: RepeatedLooks,
    folds: Integers,
    reduced: Callable[[RepeatedLooks], RepeatedLooks] | None = None,
) -> Prediction:
    """Predict the class of every object from the tables fitted to the objects of the other folds.

    Parameters
    ----------
    candidate
        What is fitted.
    looks
        At all objects.
    folds
        Number of each object's fold, shape (n,).
    reduced
        Takes some of the looks to fit to.
    """
    n = len(looks)
    log_beliefs = np.empty((n, len(STAGES), looks.shape.classes))
    for fold in np.unique(folds).tolist():
        rest = looks.of_objects(np.flatnonzero(folds != fold))
        held_out = np.flatnonzero(folds == fold)
        fitted = candidate.fit(rest if reduced is None else reduced(rest))
        log_beliefs[held_out] = predict(fitted, looks.of_objects(held_out)).log_beliefs
    return Prediction(log_beliefs, looks.true)


def stratified_folds(true: Sequence[int] | Integers, folds: int, seed: int) -> Integers:
    """Deal the objects of each class to folds at random, as evenly as possible; shape (n,).

    Raises
    ------
    ArgumentError
        If there are fewer than two folds or fewer than two objects.

    Examples
    --------
    >>> np.bincount(stratified_folds([0] * 6 + [1] * 3, folds=3, seed=0)).tolist()
    [3, 3, 3]
    """
    if folds < 2 or len(true) < 2:
        raise beltsort.ArgumentError(
            f"{len(true)} objects cannot be dealt to {folds} folds, expected at least 2 of "
            "both: one is held out"
        )
    random = np.random.default_rng(seed).random(len(true))
    dealt = np.empty(len(true), dtype=np.int64)
    dealt[np.lexsort((random, np.asarray(true)))] = np.arange(len(true)) % folds
    return dealt
