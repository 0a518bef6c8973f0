"""Small databases."""

from typing import Any

import numpy as np

from beltsort.perception import NearestNeighbour, PerceptionConfig

CLASSES = ["a", "b", "c"]


def database(seed: int = 0, n: int = 12, **settings: Any) -> NearestNeighbour:
    rng = np.random.default_rng(seed)
    rows = rng.gamma(0.5, size=(n, 308)) * (rng.random((n, 308)) < 0.3)
    return NearestNeighbour.train(rows, np.arange(n) % 3, CLASSES, PerceptionConfig(voxel=0.004), **settings)
