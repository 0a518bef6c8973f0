"""Counts of labels, and the observation table that they support."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

import beltsort
from beltsort.util.defaults import UNIFORM_PRIOR

Integers = NDArray[np.int64]
Array = NDArray[np.float64]


@dataclass(frozen=True)
class Look:
    """The labels of one or two scans of one object.

    Attributes
    ----------
    position, viewpoint, true
        Where the object stood, where the camera stood, the object's class: indices.
    observed
        Index of the first scan's label, or None: the object was not found or not labelled.
    again
        The label of a second scan that differs in nothing but sensor noise and arm repeatability; None if
        there was no second scan or it gave no label.
    """

    position: int
    viewpoint: int
    true: int
    observed: int | None
    again: int | None = None


@dataclass(frozen=True, eq=False)
class Counts:
    """How often each label was seen in each table row, every count an independent object.

    H positions, K viewpoints, L classes, Z labels.

    Attributes
    ----------
    counts
        Objects by position, viewpoint, true class and label, shape (H, K, L, Z).
    missed
        Objects that got no label, by position, viewpoint and true class, shape (H, K, L); no part of
        `counts`.
    agree, pairs
        Objects scanned twice with the same label, and objects labelled twice, shape (H, K).
    label_classes
        The class that each label names, or None if it names none, shape (Z,); None: the labels are the
        classes.
    """

    counts: Integers
    missed: Integers
    agree: Integers
    pairs: Integers
    label_classes: tuple[int | None, ...] | None = None

    def __repr__(self) -> str:
        """Return the sizes, and how many objects were counted."""
        positions, viewpoints, classes, labels = self.counts.shape
        return (
            f"Counts({self.counts.sum()} labelled objects, {self.missed.sum()} without a label; positions "
            f"{positions}, viewpoints {viewpoints}, classes {classes}, labels {labels})"
        )

    def probabilities(self, smoothing: float | Array) -> Array:
        """Return the posterior mean of the observation table, shape (H, K, L, Z); rows sum to 1.

        Parameters
        ----------
        smoothing
            Pseudo-counts added to every entry: the parameters of a Dirichlet prior, a number or of shape
            (H, K, L, Z). Positive, since a zero in the table makes a belief irrevocable; 1 is a uniform
            prior, `pooled_prior` one for few objects. Too large pulls all rows towards the prior.

        Raises
        ------
        ArgumentError
            If `smoothing` is not positive, too large to add up, or of another shape.
        """
        check_smoothing(smoothing, self.counts.shape[-1])
        if np.ndim(smoothing) and np.shape(smoothing) != self.counts.shape:
            raise beltsort.ArgumentError(
                f"smoothing has shape {np.shape(smoothing)}, expected a number or an array of shape "
                f"{self.counts.shape}: one pseudo-count for each entry"
            )
        smoothed = self.counts + smoothing
        probabilities: Array = smoothed / smoothed.sum(axis=-1, keepdims=True)
        return probabilities

    def accuracy(self) -> Array:
        """Return the share of right labels, mean over true classes, shape (H, K).

        Labels that name no class are left out. NaN where a class has no other ones.
        """
        classes = self.counts.shape[2]
        named = range(classes) if self.label_classes is None else self.label_classes
        is_right = np.array([[label == true for label in named] for true in range(classes)])  # (L, Z)
        is_class = np.array([label is not None for label in named])  # (Z,)
        with np.errstate(invalid="ignore"):
            right: Array = (self.counts * is_right).sum(axis=-1) / (self.counts * is_class).sum(axis=-1)
        accuracy: Array = right.mean(axis=-1)
        return accuracy

    def agreement(self) -> tuple[Array, Array]:
        """Return how often two scans of one object agree, and the standard error, shape (H, K) each."""
        with np.errstate(invalid="ignore", divide="ignore"):
            rate = self.agree / self.pairs
            return rate, np.sqrt(rate * (1.0 - rate) / self.pairs)

    def chance_agreement(self) -> Array:
        """Return how often two scans of *different* objects of one class agree, shape (H, K).

        That is the agreement of repeated looks if they were independent, as the paper's model has it. The
        estimate sum n (n - 1) / (N (N - 1)) of each row is unbiased; NaN where a class has fewer than two.
        """
        total = self.counts.sum(axis=-1)
        with np.errstate(invalid="ignore"):
            rows: Array = (self.counts * (self.counts - 1)).sum(axis=-1) / (total * (total - 1))
        agreement: Array = rows.mean(axis=-1)
        return agreement

    def repeat(self) -> Array:
        """Return the share of repeated looks that only return the earlier label, shape (H, K), in [0, 1].

        It solves agreement = repeat + (1 - repeat) * chance agreement. NaN where too little was counted.
        """
        chance = self.chance_agreement()
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.clip((self.agreement()[0] - chance) / (1.0 - chance), 0.0, 1.0)

    def model(
        self,
        classes: Sequence[str],
        viewpoints: Sequence[str],
        *,
        smoothing: float | Array = UNIFORM_PRIOR,
        repeats: bool = False,
        **settings: Any,
    ) -> "beltsort.SortingModel":
        """Build a model from the smoothed table; it keeps the counts.

        Parameters
        ----------
        classes, viewpoints
            Names.
        smoothing
            See `probabilities`.
        repeats
            Whether to set the model's `repeat`, from the method `repeat`: 0 where that is NaN, and at most
            1 - 1 / (n + 2) after n pairs (Laplace's rule of succession), since at 1 a pair that differs would
            be impossible.
        **settings
            Further arguments of `beltsort.SortingModel`: rewards, discount, travel, names of labels.
        """
        if repeats:
            most = 1.0 - 1.0 / (self.pairs + 2)
            settings["repeat"] = np.nan_to_num(np.minimum(self.repeat(), most), nan=0.0)
        return beltsort.SortingModel(
            classes,
            viewpoints,
            self.probabilities(smoothing),
            counts=self.counts,
            smoothing=smoothing,
            **settings,
        )


def check_smoothing(smoothing: float | Array, labels: int) -> None:
    """Raise an `ArgumentError` unless `smoothing` is positive and so many of it add up."""
    pseudo_counts = np.asarray(smoothing, dtype=np.float64)
    wrong = pseudo_counts[~((pseudo_counts > 0.0) & np.isfinite(pseudo_counts * labels))]
    if wrong.size:
        raise beltsort.ArgumentError(
            f"smoothing is {wrong.flat[0]}, expected a positive number, not infinite: zeros in a table make "
            f"beliefs irrevocable; {UNIFORM_PRIOR:g} is a uniform prior"
        )


def count(
    looks: Iterable[Look],
    positions: int,
    viewpoints: int,
    classes: int,
    label_classes: Sequence[int | None] | None = None,
) -> Counts:
    """Count looks at independent objects.

    Parameters
    ----------
    looks
        One for each object: two looks at one object in one row would not be independent.
    positions, viewpoints, classes
        H, K, L.
    label_classes
        The class that each of the Z labels names, or None, as in `LabelRule.label_classes`; default: the
        labels are the classes.

    Raises
    ------
    ArgumentError
        If a label names a class that there is not.

    Examples
    --------
    >>> looks = [Look(position=0, viewpoint=0, true=1, observed=label) for label in (1, 1, 0, None)]
    >>> counts = count(looks, positions=1, viewpoints=1, classes=2)
    >>> counts.probabilities(smoothing=1.0)[0, 0].tolist()
    [[0.5, 0.5], [0.4, 0.6]]

    With a label for "not recognised":

    >>> looks = [Look(position=0, viewpoint=0, true=1, observed=label) for label in (1, 1, 0, 2)]
    >>> count(looks, positions=1, viewpoints=1, classes=2, label_classes=(0, 1, None)).counts.tolist()
    [[[[0, 0, 0], [1, 2, 1]]]]
    """
    labels = tuple(range(classes) if label_classes is None else label_classes)
    if any(label is not None and not 0 <= label < classes for label in labels):
        raise beltsort.ArgumentError(
            f"label_classes are {list(labels)}, expected class indices from 0 to {classes - 1}, or None"
        )
    counts = np.zeros((positions, viewpoints, classes, len(labels)), dtype=np.int64)
    missed = np.zeros((positions, viewpoints, classes), dtype=np.int64)
    agree, pairs = np.zeros((2, positions, viewpoints), dtype=np.int64)
    for look in looks:
        if look.observed is None:
            missed[look.position, look.viewpoint, look.true] += 1
            continue
        counts[look.position, look.viewpoint, look.true, look.observed] += 1
        if look.again is not None:
            pairs[look.position, look.viewpoint] += 1
            agree[look.position, look.viewpoint] += look.again == look.observed
    return Counts(counts, missed, agree, pairs, None if label_classes is None else labels)
