"""Observation tables with latent modes: an object's kind is its class and its mode.

How an object lies, or how it looks, stays the same from look to look, and makes its labels depend on each
other. Given its kind, they do not. So a belief over kinds is exact where one over classes is overconfident.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

import beltsort
from beltsort.tables.counts import check_smoothing
from beltsort.tables.expectation import Mixture, Problem
from beltsort.tables.intervals import dirichlet_intervals
from beltsort.tables.repeated_looks import NONE, Array, Integers, RepeatedLooks
from beltsort.util.defaults import UNIFORM_PRIOR
from beltsort.util.extras import extra
from beltsort.util.naming import suggests_keywords
from beltsort.util.randomness import generator
from beltsort.util.representation import short_repr

with extra("perception"):
    from scipy.special import logsumexp

ENOUGH_LOOKS = 3  # looks at an object that identify its mode
START_SPREAD = 4.0  # pseudo-looks of the random tables that EM starts from: the fewer, the farther apart


@suggests_keywords
@dataclass(frozen=True, eq=False)
class ModeSettings:
    """How modes are fitted.

    Attributes
    ----------
    smoothing
        Pseudo-counts added to every entry of a class's own tables, as in `Counts.probabilities`: a number, or
        of shape (H, K, L, Z).
    pseudo_looks
        Looks that a mode's tables are shrunk towards the class's own with, in each row. Too few, and modes
        fit chance: they then predict worse than no modes. Too many, and all modes are alike.
    position_looks
        Looks that a mode's tables at one position are shrunk with towards its tables of all positions.
    pseudo_objects
        Objects added to every mode of a class: the parameter of the prior of its weights.
    starts
        Random starts of EM, of which the best is kept.
    seed
        Of the starts.

    Raises
    ------
    ArgumentError
        If a number is out of range.
    """

    smoothing: float | Array = UNIFORM_PRIOR
    pseudo_looks: float = 8.0
    position_looks: float = 200.0
    pseudo_objects: float = 1.0
    starts: int = 10
    seed: int = 0

    __repr__ = short_repr

    def __post_init__(self) -> None:
        """Check the numbers."""
        check_smoothing(self.smoothing, labels=1)
        for name in ("pseudo_looks", "position_looks", "pseudo_objects"):
            if not 0.0 < getattr(self, name) < np.inf:
                raise beltsort.ArgumentError(
                    f"{name} is {getattr(self, name)}, expected a positive number; leave it at its default"
                )
        if self.starts < 1 or self.seed < 0:
            raise beltsort.ArgumentError(
                f"starts is {self.starts} and seed is {self.seed}, expected at least 1 and 0"
            )


@dataclass(frozen=True, eq=False)
class ModeTables:
    """Observation tables of N kinds, ordered by class.

    Attributes
    ----------
    weights
        Probabilities of the modes of each class, the most frequent first; L tuples.
    pseudo_counts
        Parameters of the Dirichlet posterior of each row given the objects' modes, shape (H, K, N, Z).
    objects
        Expected number of objects of each kind among those fitted to, shape (N,).
    names
        Names of the modes of each class; empty tuples where they have none.
    """

    weights: tuple[tuple[float, ...], ...]
    pseudo_counts: Array
    objects: Array
    names: tuple[tuple[str, ...], ...]

    __repr__ = short_repr

    @property
    def p_obs(self) -> Array:
        """The tables, shape (H, K, N, Z); rows sum to 1."""
        tables: Array = self.pseudo_counts / self.pseudo_counts.sum(axis=-1, keepdims=True)
        return tables

    @property
    def kinds(self) -> int:
        """Number of kinds N."""
        return int(self.pseudo_counts.shape[2])

    @property
    def class_of(self) -> Integers:
        """Class of each kind, shape (N,)."""
        return np.repeat(np.arange(len(self.weights)), [len(each) for each in self.weights])

    def log_likelihoods(self, looks: RepeatedLooks) -> Array:
        """Return the logarithm of the probability of each object's labels given each class, (n, L)."""
        joint = self._log_joint(looks)
        by_class = np.split(joint, np.flatnonzero(np.diff(self.class_of)) + 1, axis=1)
        return np.stack([logsumexp(each, axis=1) for each in by_class], axis=1)

    def as_modes(self) -> Self:
        """Return these tables: the counterpart of `StickyLabels.as_modes`."""
        return self

    def mode_posteriors(self, looks: RepeatedLooks) -> Array:
        """Return the probability of each kind given an object's class and labels, shape (n, N)."""
        joint = np.where(self.class_of == looks.true[:, None], self._log_joint(looks), -np.inf)
        posterior: Array = np.exp(joint - logsumexp(joint, axis=1, keepdims=True))
        return posterior

    def _log_joint(self, looks: RepeatedLooks) -> Array:
        """Return the logarithm of P(mode, labels | class), shape (n, N)."""
        log_tables = np.log(self.p_obs).swapaxes(2, 3).reshape(-1, self.kinds)  # (H * K * Z, N)
        counts = looks.counts().reshape(len(looks), -1).astype(np.float64)
        joint: Array = counts @ log_tables + np.log(np.concatenate(self.weights))
        return joint

    def intervals(self) -> tuple[Array, Array]:
        """Return the ends of the 95 % intervals given the objects' modes, shape (H, K, N, Z) each."""
        return dirichlet_intervals(self.pseudo_counts)


def one_mode_reasons(looks: RepeatedLooks) -> tuple[str | None, ...]:
    """Return for each class why its modes cannot be told apart, or None.

    Modes that are known for some object need no further reason to be told apart.
    """
    enough = looks.labelled() >= ENOUGH_LOOKS

    def reason(label: int) -> str | None:
        own = looks.true == label
        if (looks.modes[own] != NONE).any():
            return None
        if own.sum() < 2:
            return f"{own.sum()} object{'s' if own.sum() != 1 else ''} of the class, expected two or more"
        if (own & enough).sum() < 2:
            return f"fewer than two of its objects were looked at {ENOUGH_LOOKS} times"
        return None

    return tuple(reason(label) for label in range(looks.shape.classes))


def fit_modes(looks: RepeatedLooks, modes: int, settings: ModeSettings | None = None) -> ModeTables:
    """Fit tables with up to `modes` modes per class, maximum a posteriori by EM.

    A class with one mode has the tables of `Counts.probabilities`. With more, modes are first fitted to the
    looks of all positions together, which finds the modes. Their tables, times what distinguishes a position
    in the class's own tables, are then the prior of a fit with tables of each position.

    Modes with less than one object are dropped. A class whose modes are known for all or some objects has
    those modes if `modes` is more than 1. A class whose modes cannot be told apart has one
    (`one_mode_reasons`).

    Parameters
    ----------
    looks
        The looks. The order of objects does not matter; that of looks at an object does for classes with one
        mode only: the first in each table row counts.
    modes
        Largest number of modes of a class.
    settings
        See `ModeSettings`.

    Raises
    ------
    ArgumentError
        If `modes` is below 1.

    Examples
    --------
    >>> from beltsort.tables.repeated_looks import LooksAtObject, TableShape
    >>> often = LooksAtObject(true=0, looks=((0, 0, 0),) * 20)  # always seen as class 0
    >>> never = LooksAtObject(true=0, looks=((0, 0, 1),) * 20)
    >>> looks = RepeatedLooks.of([often] * 30 + [never] * 10, TableShape(1, 1, 1, 2))
    >>> tables = fit_modes(looks, modes=2)
    >>> [round(weight, 2) for weight in tables.weights[0]], tables.p_obs[0, 0].round(2).tolist()
    ([0.74, 0.26], [[1.0, 0.0], [0.03, 0.97]])
    """
    if modes < 1:
        raise beltsort.ArgumentError(f"modes is {modes}, expected at least 1: the modes of each class")
    settings = settings or ModeSettings()
    own = looks.first_counts().astype(np.float64) + settings.smoothing  # (H, K, L, Z)
    reasons = one_mode_reasons(looks)
    parts = []
    for label in range(looks.shape.classes):
        several = modes > 1 and reasons[label] is None
        part = _ClassFit(looks, label, settings).tables(modes) if several else None
        parts.append(part or _one_mode(looks, label, own[:, :, label]))
    return ModeTables(
        tuple(weights for part in parts for weights in part.weights),
        np.concatenate([part.pseudo_counts for part in parts], axis=2),
        np.concatenate([part.objects for part in parts]),
        tuple(names for part in parts for names in part.names),
    )


def _one_mode(looks: RepeatedLooks, label: int, own: Array) -> ModeTables:
    objects = np.array([(looks.true == label).sum()], dtype=np.float64)
    return ModeTables(((1.0,),), own[:, :, None], objects, ((),))


class _ClassFit:
    """Fits the modes of one class."""

    def __init__(self, looks: RepeatedLooks, label: int, settings: ModeSettings) -> None:
        members = np.flatnonzero(looks.true == label)
        self.counts = looks.counts()[members].astype(np.float64)  # (n, H, K, Z)
        self.known = looks.modes[members]
        self.names = looks.mode_names[label] if (self.known != NONE).any() else ()
        self.settings = settings
        self.rng = generator(settings.seed, label)
        # All looks, not the first in each row alone: modes account for the dependence of further ones.
        smoothing = np.broadcast_to(settings.smoothing, looks.first_counts().shape)
        own = self.counts.sum(axis=0) + smoothing[:, :, label]
        self.own = own / own.sum(axis=-1, keepdims=True)  # (H, K, Z)
        pooled = own.sum(axis=0)
        self.pooled = pooled / pooled.sum(axis=-1, keepdims=True)  # (K, Z)

    def tables(self, modes: int) -> ModeTables | None:
        """Return the class's tables; None if all modes but one are empty."""
        modes = len(self.names) or modes
        possible = np.ones((len(self.counts), modes), dtype=bool)
        seen = self.known != NONE
        possible[seen] = np.arange(modes) == self.known[seen, None]
        mixture, problem, kept = self._of_all_positions(possible)
        if len(kept) == 1:
            return None
        positions, viewpoints, labels = self.own.shape
        if positions > 1:
            mixture, problem = self._of_each_position(mixture, problem)
        posterior = problem.expectation(mixture)[0]
        objects = posterior[0].sum(axis=0)
        order = np.argsort(-objects, kind="stable")
        shape = (len(kept), positions, viewpoints, labels)
        prior = np.broadcast_to(problem.pseudo_looks, (len(kept), *problem.counts.shape[1:])).reshape(shape)
        counts = np.einsum("om,ohkz->mhkz", posterior[0], self.counts)
        weights = problem.maximisation(posterior).weights[0, order]
        return ModeTables(
            (tuple(weights.tolist()),),
            (counts + prior)[order].transpose(1, 2, 0, 3),
            objects[order],
            (tuple(self.names[mode] for mode in kept[order]) if self.names else (),),
        )

    def _of_all_positions(self, possible: NDArray[np.bool_]) -> tuple[Mixture, Problem, Integers]:
        """Return the best mixture of all starts without its empty modes, its problem, and the modes kept."""
        settings, modes = self.settings, possible.shape[1]
        prior = settings.pseudo_looks * self.pooled  # (K, Z)
        problem = Problem(self.counts.sum(axis=1), possible, prior, settings.pseudo_objects)
        shape = (settings.starts, modes, *self.pooled.shape)
        # Starts are random tables and not random modes of objects, so the order of objects does not matter.
        drawn = self.rng.standard_gamma(np.broadcast_to(START_SPREAD * self.pooled, shape)) + 1e-3
        tables = drawn / drawn.sum(axis=-1, keepdims=True)
        mixture, value = problem.maximise(Mixture(np.full(shape[:2], 1.0 / modes), tables))
        mixture, kept = mixture.only(int(value.argmax()), np.arange(modes)), np.arange(modes)
        while len(kept) > 1:
            objects = problem.expectation(mixture)[0][0].sum(axis=0)
            if objects.min() >= 1.0:
                break
            rest = np.delete(np.arange(len(kept)), objects.argmin())
            kept, problem = kept[rest], problem.without(rest)
            mixture = problem.maximise(mixture.only(0, rest))[0]
        return mixture, problem, kept

    def _of_each_position(self, found: Mixture, pooled: Problem) -> tuple[Mixture, Problem]:
        """Return the mixture with tables of each position, and the problem that it solves."""
        rows = (-1, self.own.shape[0] * self.own.shape[1], self.own.shape[2])  # (., H * K, Z)
        towards = found.tables[0][:, None] * self.own / self.pooled  # (M, H, K, Z)
        towards = (towards / towards.sum(axis=-1, keepdims=True)).reshape(rows)
        problem = Problem(
            self.counts.reshape(rows),
            pooled.possible,
            self.settings.position_looks * towards,
            pooled.pseudo_objects,
        )
        return problem.maximise(Mixture(found.weights, towards[None]))[0], problem
