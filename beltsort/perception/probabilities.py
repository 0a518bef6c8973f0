"""Classifiers that return probabilities, such as a network that ends in a softmax."""

from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

import beltsort
from beltsort.errors import DatabaseError
from beltsort.geometry import Points
from beltsort.perception.checks import as_array
from beltsort.perception.classifier import Match, Scores, check_distribution


class ProbabilityClassifier(Protocol):
    """Returns the probability of every class; `FromProbabilities` makes a `Classifier` of it.

    Examples
    --------
    >>> class ByHeight:
    ...     classes = ("low", "high")
    ...
    ...     def probabilities(self, points, camera):
    ...         high = 1.0 / (1.0 + np.exp(-100.0 * (np.ptp(points[:, 2]) - 0.06)))
    ...         return [1.0 - high, high]
    >>> candidate, camera = np.array([[0.0, 0.0, 0.05], [0.0, 0.0, 0.15]]), np.ones(3)
    >>> match = FromProbabilities(ByHeight()).classify(candidate, camera)
    >>> match.label, match.probabilities.round(2).tolist()
    (1, [0.02, 0.98])
    """

    @property
    def classes(self) -> tuple[str, ...]:
        """Names of the classes; a label is an index into them."""

    def probabilities(self, points: Points, camera: Points) -> ArrayLike:
        """Return the probability of each class for one candidate, shape (L,), sum 1.

        Parameters
        ----------
        points
            Shape (n, 3), metres.
        camera
            The camera's position in the same frame, shape (3,).
        """


class FromProbabilities:
    """Labels a candidate with the most probable class, the first of equally probable ones.

    A network that is too sure of itself does not make beliefs so: they follow the observation tables, which
    count how often its labels, and levels of confidence, are right.

    Parameters
    ----------
    classifier
        Returns probabilities.
    """

    def __init__(self, classifier: ProbabilityClassifier) -> None:
        self.classifier = classifier
        self.classes: tuple[str, ...] = tuple(classifier.classes)

    def classify(self, points: Points, camera: Points) -> Match:
        """Classify one candidate, as `Classifier.classify` does.

        Raises
        ------
        DatabaseError
            If the classifier does not return a distribution over its classes.
        """
        returned = self.classifier.probabilities(points, camera)
        try:
            probabilities: Scores = as_array("probabilities", returned, beltsort.ArgumentError)
            check_distribution(probabilities, len(self.classes))
        except beltsort.ArgumentError as reason:
            raise DatabaseError(
                f"{type(self.classifier).__name__}, a classifier of {list(self.classes)}, is wrong: {reason}"
            ) from reason
        return Match(int(np.argmax(probabilities)), probabilities, probabilities=probabilities)
