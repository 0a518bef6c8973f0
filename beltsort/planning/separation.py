"""How well a look tells two classes apart, and how much further looks add."""

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from beltsort._core import Belief, SortingModel
from beltsort.util.extras import extra

with extra("perception"):
    from scipy.optimize import minimize_scalar

Array = NDArray[np.float64]

INFORMATIVE = 1e-9  # nats; rounding leaves less between equal rows


@dataclass(frozen=True)
class Separation:
    """How well the best look tells two classes apart.

    Attributes
    ----------
    classes
        Names of the two classes.
    viewpoint
        Name of the viewpoint that tells them apart best.
    position
        Index of the position that it does so at.
    information
        Chernoff information of a look there, nats: the probability of confusing the classes falls as
        ``exp(-n * information)`` with n independent looks.
    looks
        Independent looks after which confusing them costs less than one more look; None if no number does.
    """

    classes: tuple[str, str]
    viewpoint: str
    position: int
    information: float
    looks: float | None


def chernoff_information(p: Array, q: Array) -> float:
    """Return the Chernoff information of two distributions, nats: ``max -log sum p^s q^(1-s)``, s in [0, 1].

    Parameters
    ----------
    p, q
        Probabilities of the same labels, shape (Z,).

    References
    ----------
    T. M. Cover, J. A. Thomas, "Elements of Information Theory", 2nd ed., Wiley 2006, section 11.9.

    Examples
    --------
    >>> round(chernoff_information(np.array([0.5, 0.5]), np.array([0.5, 0.5])), 9)
    0.0
    >>> round(chernoff_information(np.array([0.9, 0.1]), np.array([0.1, 0.9])), 3)
    0.511
    """
    both = (p > 0.0) & (q > 0.0)
    if not both.any():
        return float("inf")
    log_p, log_q = np.log(p[both]), np.log(q[both])

    def affinity(s: float) -> float:
        return float(np.exp(s * log_p + (1.0 - s) * log_q).sum())

    least = minimize_scalar(affinity, bounds=(0.0, 1.0), method="bounded")  # convex in s
    return max(0.0, -float(np.log(least.fun)))


def class_tables(model: SortingModel) -> Array:
    """Return the distribution of a first look given the class, the mean over modes, shape (H, K, L, Z)."""
    weights = model.modes
    starts = np.cumsum([0, *(len(each) for each in weights)])
    rows = [
        np.einsum("m,hkmz->hkz", np.asarray(own), model.p_obs[:, :, start : start + len(own)])
        for start, own in zip(starts, weights, strict=False)
    ]
    tables = np.stack(rows, axis=2)
    normalised: Array = tables / tables.sum(axis=-1, keepdims=True)
    return normalised


def worst_separation(model: SortingModel) -> Separation | None:
    """Return the pair of classes that the best look tells apart worst.

    Classes with the same reward in every bin need not be told apart, nor do classes that never arrive. None
    if no pair is left.

    Examples
    --------
    >>> table = [[[[0.9, 0.1, 0.0], [0.2, 0.8, 0.0], [0.0, 0.0, 1.0]]]]
    >>> model = SortingModel(["nut", "bolt", "cup"], ["above"], table)
    >>> worst = worst_separation(model)
    >>> worst.classes, round(worst.information, 3), round(worst.looks)
    (('nut', 'bolt'), 0.347, 12)
    """
    tables, reward = class_tables(model), model.reward
    arriving = np.flatnonzero(model.arrival > 0.0).tolist()
    pairs = [(c, d) for c, d in combinations(arriving, 2) if not np.array_equal(reward[:, c], reward[:, d])]
    found = [_separation(model, tables, c, d) for c, d in pairs]
    return min(found, key=lambda each: each.information, default=None)


def _separation(model: SortingModel, tables: Array, first: int, second: int) -> Separation:
    """Return how well the best look tells two classes apart."""
    positions, viewpoints = tables.shape[:2]
    information = np.array(
        [
            [chernoff_information(tables[j, k, first], tables[j, k, second]) for k in range(viewpoints)]
            for j in range(positions)
        ]
    )
    j, k = np.unravel_index(int(information.argmax()), information.shape)
    best = float(information[j, k])
    return Separation(
        (model.classes[first], model.classes[second]),
        model.viewpoints[k],
        int(j),
        best,
        _looks_needed(model, first, second, best),
    )


def _looks_needed(model: SortingModel, first: int, second: int, information: float) -> float | None:
    """Return the looks after which the expected loss of confusing two classes is below the cost of a look.

    An error of probability exp(-n * information) loses `gap`; see H. Chernoff, "Sequential design of
    experiments", Ann. Math. Stat. 30 (1959).
    """
    pair = model.reward[:, [first, second]]
    best = pair.argmax(axis=0)
    gap = float((pair.max(axis=0) - pair[best[::-1], [0, 1]]).max())
    cost = cheapest_look(model)
    if gap <= cost:
        return 0.0
    return float(np.log(gap / cost)) / information if information > INFORMATIVE and cost > 0.0 else None


def cheapest_look(model: SortingModel) -> float:
    """Return the cost of the cheapest move that the model allows; 0 if it allows none."""
    costs = [model.motion_cost[start, end] for start, ends in enumerate(model.travel) for end in ends]
    return float(min(costs, default=0.0))


def independent_looks(model: SortingModel) -> SortingModel:
    """Return the model whose looks are independent given the class, each distributed as the first one."""
    one_mode = [[1.0]] * len(model.classes)
    return model.replace(p_obs=class_tables(model), modes=one_mode, repeat=0.0)


def entropy_left(model: SortingModel, looks: int, *, objects: int = 400, seed: int = 0) -> Array:
    """Return the mean entropy of the class after 0, 1, ... looks at the belt end, as a share of the prior's.

    The looks are from all viewpoints in turn. Objects and labels are drawn from the model.

    Parameters
    ----------
    model
        The model; `travel` is ignored.
    looks
        Number of looks at each object.
    objects
        Number of simulated objects.
    seed
        Of objects and labels.

    Returns
    -------
    ndarray
        Shape (looks + 1,), from 1 downwards but for noise; zeros if the class is known beforehand.

    Examples
    --------
    >>> model = SortingModel(["nut", "bolt"], ["above"], [[[[0.9, 0.1], [0.1, 0.9]]]])
    >>> entropy_left(model, looks=3)[:2].round(1).tolist()
    [1.0, 0.5]
    >>> stuck = model.replace(repeat=0.99)
    >>> bool(entropy_left(stuck, looks=8)[-1] > 3.0 * entropy_left(model, looks=8)[-1])
    True
    """
    end = model.with_positions(1)
    prior = _entropy(end.arrival)
    if prior == 0.0:
        return np.zeros(looks + 1)
    rng = np.random.default_rng(seed)
    weights = np.concatenate([p * np.asarray(own) for p, own in zip(end.arrival, end.modes, strict=True)])
    kinds = rng.choice(len(weights), size=objects, p=weights / weights.sum())
    uniform = rng.random((objects, looks, 2))
    left = np.array([_entropies(end, kind, draws) for kind, draws in zip(kinds, uniform, strict=True)])
    shares: Array = left.mean(axis=0) / prior
    return shares


def _entropies(model: SortingModel, kind: int, uniform: Array) -> list[float]:
    """Return the entropy of the belief about one object before and after each look at it."""
    belief, last = Belief(model), {}
    entropies = [_entropy(belief.probabilities[0])]
    for look, (fresh, again) in enumerate(uniform):
        k = look % len(model.viewpoints)
        if k not in last or again >= model.repeat[0, k]:
            row = np.cumsum(model.p_obs[0, k, kind])
            last[k] = int(np.searchsorted(row, fresh * row[-1], side="right"))
        belief.observe(k, [last[k]])
        entropies.append(_entropy(belief.probabilities[0]))
    return entropies


def _entropy(p: Array) -> float:
    seen = p[p > 0.0]
    return float(-(seen * np.log(seen)).sum())
