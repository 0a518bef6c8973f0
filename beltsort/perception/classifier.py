"""The protocol of classifiers: from a candidate to a label and scores."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

import beltsort
from beltsort.errors import DatabaseError
from beltsort.geometry import Points
from beltsort.util.representation import short_repr

Scores = NDArray[np.float64]

TOLERANCE = 1e-4  # of the sum of probabilities: that of a softmax in single precision misses 1 by less


@dataclass(frozen=True, eq=False)
class Match:
    """The classification of one candidate.

    Attributes
    ----------
    label
        Class index, or None if the candidate is rejected: too unlike all classes.
    scores
        Score of each class, shape (L,); larger is better. `NearestNeighbour` returns shares of votes, a
        network may return probabilities.
    distances
        Distance to the nearest training example of each class, shape (L,), infinite if it has none; None from
        a classifier without distances.
    probabilities
        Probability of each class, shape (L,), sum 1; None from a classifier without probabilities.

    Examples
    --------
    >>> import numpy as np
    >>> Match(1, np.array([0.2, 0.7, 0.1])).ranking
    (1, 0, 2)
    """

    label: int | None
    scores: Scores
    distances: Scores | None = None
    probabilities: Scores | None = None

    __repr__ = short_repr

    def __post_init__(self) -> None:
        """Refuse scores that are not finite, labels without a score, and what is no distribution."""
        shape = np.shape(self.scores)
        if len(shape) != 1 or shape[0] == 0 or not np.isfinite(self.scores).all():
            raise beltsort.ArgumentError(
                f"scores are {self.scores}, expected one finite number for each class: give shape (L,)"
            )
        if self.distances is not None and np.shape(self.distances) != shape:
            raise beltsort.ArgumentError(
                f"distances have shape {np.shape(self.distances)}, expected {shape} as the scores: give one "
                "for each class, or None"
            )
        if self.distances is not None and not (np.asarray(self.distances) >= 0.0).all():
            raise beltsort.ArgumentError(
                f"distances are {self.distances}, expected numbers of at least 0: give infinity where there "
                "is no example"
            )
        if self.probabilities is not None:
            check_distribution(self.probabilities, shape[0])
        if self.label is not None and not 0 <= self.label < shape[0]:
            raise beltsort.ArgumentError(
                f"label is {self.label}, expected a class index from 0 to {shape[0] - 1}, or None: "
                "give scores for all classes"
            )

    @property
    def ranking(self) -> tuple[int, ...]:
        """The classes, best first: by score, then by distance, then as they are numbered."""
        keys = () if self.distances is None else (self.distances,)
        return tuple(int(label) for label in np.lexsort((*keys, -self.scores)))

    @property
    def distance(self) -> float | None:
        """Distance to the best class (the one that was rejected, if there is no label)."""
        return self._ranked_distance(0)

    @property
    def runner_up(self) -> float | None:
        """Distance to the second-best class, infinite if there is none; close to `distance` if in doubt."""
        return self._ranked_distance(1)

    @property
    def margin(self) -> float | None:
        """How much nearer the best class is than every other one, in [-1, 1]; None without distances.

        With d the distance to the best class and r that to the nearest other class: (r - d) / (r + d), so 0
        if in doubt and 1 if the best class fits exactly or is the only one. It is negative if the best class
        has the most votes but not the nearest example.
        """
        if self.distances is None:
            return None
        best = self.best
        d, r = float(self.distances[best]), float(np.delete(self.distances, best).min(initial=np.inf))
        if np.isinf(r):
            return 0.0 if np.isinf(d) else 1.0
        if np.isinf(d):
            return -1.0
        return (r - d) / (r + d) if r + d > 0.0 else 0.0

    @property
    def best(self) -> int:
        """The label, or the first of `ranking` if the candidate is rejected."""
        return self.ranking[0] if self.label is None else self.label

    def _ranked_distance(self, rank: int) -> float | None:
        if self.distances is None:
            return None
        return float(self.distances[self.ranking[rank]]) if rank < len(self.scores) else np.inf

    def within(self, reject: float | None) -> "Match":
        """Return the classification, without its label if the distance is above `reject`."""
        if reject is None or self.distance is None or self.distance <= reject:
            return self
        return replace(self, label=None)


def check_distribution(probabilities: Scores, classes: int) -> None:
    """Raise an `ArgumentError` unless `probabilities` are one number for each class, none negative, sum 1."""
    remedy = "give one for each class, as softmax returns them"
    if np.shape(probabilities) != (classes,):
        raise beltsort.ArgumentError(
            f"probabilities have shape {np.shape(probabilities)}, expected ({classes},): {remedy}"
        )
    if not (np.isfinite(probabilities).all() and (probabilities >= 0.0).all()):
        raise beltsort.ArgumentError(
            f"probabilities are {probabilities.tolist()}, expected finite numbers, none negative: {remedy}"
        )
    if abs(probabilities.sum() - 1.0) > TOLERANCE:
        raise beltsort.ArgumentError(
            f"probabilities are {probabilities.tolist()} with the sum {probabilities.sum():g}, expected the "
            f"sum 1 (within {TOLERANCE:g}): {remedy}"
        )


class Classifier(Protocol):
    """Labels a candidate; `NearestNeighbour` is one, and a network of your own can be another.

    Examples
    --------
    >>> import numpy as np
    >>> class ByHeight:
    ...     classes = ("low", "high")
    ...
    ...     def classify(self, points, camera):
    ...         high = float(np.ptp(points[:, 2]) > 0.06)
    ...         return Match(int(high), np.array([1.0 - high, high]))
    >>> ByHeight().classify(np.array([[0.0, 0.0, 0.05], [0.0, 0.0, 0.15]]), np.ones(3)).label
    1
    """

    @property
    def classes(self) -> tuple[str, ...]:
        """Names of the classes; a label is an index into them."""

    def classify(self, points: Points, camera: Points) -> Match:
        """Classify one candidate.

        Parameters
        ----------
        points
            Shape (n, 3), metres.
        camera
            The camera's position in the same frame, shape (3,).
        """


def check_classes(classifier: Classifier, classes: Sequence[str], whose: str) -> None:
    """Refuse a classifier whose class indices mean other classes: its labels would be counted as those.

    Parameters
    ----------
    classifier
        The classifier.
    classes
        The classes expected, in order.
    whose
        What they belong to, such as "the cell's", for the message.

    Raises
    ------
    DatabaseError
        If the classifier has other classes, or the same in another order.
    """
    known, expected = list(classifier.classes), list(classes)
    if known == expected:
        return
    remedy = (
        "list them in the classifier's order"
        if sorted(known) == sorted(expected)
        else "train a classifier for these classes, or name the ones that it knows"
    )
    raise DatabaseError(
        f"the classifier knows the classes {known}, expected {whose} {expected}, in this order: {remedy}"
    )
