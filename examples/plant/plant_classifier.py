"""A classifier that returns probabilities, which `plant.toml` names as `plant_classifier:load`.

Put a network of your own in its place: all it needs are `classes`, and `probabilities` of one candidate.
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from beltsort.geometry import Points
from beltsort.perception import KernelRidge

TRAINED = "plant.npz"


class Network:
    """Stands for a network: kernel ridge regression on the descriptors of training scans."""

    def __init__(self, trained: KernelRidge) -> None:
        self.trained = trained
        self.classes = trained.classes

    def probabilities(self, points: Points, camera: Points) -> NDArray[np.float64]:
        """Return the probability of each class, shape (L,)."""
        return self.trained.classify(points, camera).scores


def load() -> Network:
    """Load what is trained, from the file beside this one."""
    return Network(KernelRidge.load(Path(__file__).parent / TRAINED))
