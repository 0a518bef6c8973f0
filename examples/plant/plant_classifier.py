"""A classifier that returns probabilities, as a network does: a softmax of the distances to training scans.

`plant.toml` names it as `plant_classifier:load`. Put your own network in its place: `classes`, and
`probabilities` of one candidate.
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from beltsort.geometry import Points
from beltsort.perception import NearestNeighbour

DATABASE = "plant.npz"
TEMPERATURE = 0.1  # of the softmax, in units of the distance


class Softmax:
    """Probabilities from the distance to the nearest training example of each class."""

    def __init__(self, database: NearestNeighbour) -> None:
        self.database = database
        self.classes = database.classes

    def probabilities(self, points: Points, camera: Points) -> NDArray[np.float64]:
        """Return the probability of each class, shape (L,)."""
        distances = self.database.classify(points, camera).distances
        assert distances is not None, "NearestNeighbour returns distances"
        weights = np.exp((distances.min() - distances) / TEMPERATURE)
        return np.asarray(weights / weights.sum())


def load() -> Softmax:
    """Load the database beside this file."""
    return Softmax(NearestNeighbour.load(Path(__file__).parent / DATABASE))
