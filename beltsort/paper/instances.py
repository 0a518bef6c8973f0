"""The models of the experiments: the paper's tables, the simulated cell's, and variants of them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from beltsort import ArgumentError, SortingModel
from beltsort.models import paper
from beltsort.paper.printed import CLASSES_DRAWN
from beltsort.planning.bins import sorts_into_classes
from beltsort.planning.decisions import right_bins

FADING = 0.2
"""By how much the table of each position beyond the paper's two is mixed with pure chance."""


@dataclass(frozen=True)
class Instance:
    """Tables under a name.

    Attributes
    ----------
    name
        `paper`, `cell`, or `own` for a model of one's own.
    model
        With as many positions as it has tables for.
    """

    name: str
    model: SortingModel


CELL = "cell"
"""Name of the simulated cell's tables."""

PAPER = Instance("paper", paper())
"""Three of eight blocks as printed, five of ours; see `beltsort.models.paper`."""


@dataclass(frozen=True)
class Objects:
    """A set of classes that objects are drawn from.

    Attributes
    ----------
    name
        Its name in tables and figures.
    classes
        Drawn from uniformly.
    """

    name: str
    classes: tuple[str, ...]

    def labels(self, model: SortingModel) -> list[int] | None:
        """Return the class indices to draw from, or None if that is every class of the model."""
        if set(self.classes) == set(model.classes):
            return None
        return [model.classes.index(name) for name in self.classes]


TWO = Objects("two classes", CLASSES_DRAWN)
FOUR = Objects("four classes", tuple(paper().classes))
OBJECTS = (TWO, FOUR)


def punished(model: SortingModel) -> NDArray[np.bool_]:
    """Return which decisions cost something since the object is of another class, shape (B, L).

    Bins where no class belongs, such as a manual bin, are not among them.
    """
    right = right_bins(model)
    found: NDArray[np.bool_] = ~right & right.any(axis=1, keepdims=True) & (model.reward < 0.0)
    return found


def penalty_of(model: SortingModel) -> float:
    """Return the largest loss of a wrong decision: `r_min`, or that of the reward matrix.

    Raises
    ------
    ArgumentError
        If no wrong decision costs anything.

    Examples
    --------
    >>> penalty_of(paper())
    50.0
    """
    losses = -model.reward[punished(model)]
    if not losses.size:
        raise ArgumentError(
            "no decision of the model costs anything, so there is no penalty to vary; give wrong decisions a "
            "reward below 0 (reward, or r_min)"
        )
    return float(losses.max())


def with_penalty(model: SortingModel, r_min: float) -> SortingModel:
    """Return the model with another penalty of wrong decisions; smaller losses change in proportion.

    Examples
    --------
    >>> with_penalty(paper(), 7.0) == paper().replace(r_min=7.0)
    True
    """
    if sorts_into_classes(model):
        return model.replace(r_min=r_min)
    factor = r_min / penalty_of(model)
    return model.replace(reward=np.where(punished(model), factor * model.reward, model.reward))


def with_more_positions(model: SortingModel, positions: int) -> SortingModel:
    """Return the model with so many positions; tables of further ones fade from the last one's to chance."""
    known = model.p_obs
    chance = 1.0 / len(model.classes)
    further = [
        known[-1] + (chance - known[-1]) * min(1.0, FADING * step)
        for step in range(1, positions - len(known) + 1)
    ]
    return model.replace(p_obs=np.stack([*known, *further])[:positions])


def sharpened(model: SortingModel, exponent: float) -> SortingModel:
    """Return the model with every row of its tables raised to the exponent and normalised.

    A planner that uses it takes its classifier for better (exponent above 1) or worse than it is.
    """
    powers = model.p_obs**exponent
    return model.replace(p_obs=powers / powers.sum(axis=-1, keepdims=True))


def with_arrival(model: SortingModel, objects: Objects, share: float) -> SortingModel:
    """Return the model with an arrival prior between uniform (share 0) and uniform on `objects` (share 1)."""
    uniform = np.full(len(model.classes), 1.0 / len(model.classes))
    known = np.array([name in objects.classes for name in model.classes]) / len(objects.classes)
    return model.replace(arrival=((1.0 - share) * uniform + share * known).tolist())
