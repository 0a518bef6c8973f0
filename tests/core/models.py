"""Models to test with."""

from pathlib import Path
from typing import Any

import numpy as np

from beltsort import Belief, SortingModel

PAPER = Path(__file__).parent.parent / "fixtures" / "paper.json"


def named(prefix: str, count: int) -> list[str]:
    return [f"{prefix}{i}" for i in range(count)]


# H positions, K viewpoints and n classes (the paper's L).


def random_model(seed: int, h: int = 2, k: int = 2, n: int = 3, **settings: Any) -> SortingModel:
    p_obs = np.random.default_rng(seed).dirichlet(np.ones(n), size=(h, k, n))
    return SortingModel(named("c", n), named("v", k), p_obs, **settings)


def seeing_model(h: int = 1, k: int = 1, n: int = 3, **settings: Any) -> SortingModel:
    """Every look tells the class."""
    return SortingModel(named("c", n), named("v", k), np.tile(np.eye(n), (h, k, 1, 1)), **settings)


def beyond_model(seed: int, h: int = 2, k: int = 2, **settings: Any) -> SortingModel:
    """Three classes, of which one has two modes, in two bins, by looks of two labels."""
    rng = np.random.default_rng(seed)
    keys: dict[str, Any] = {
        "labels": ["seen, sure", "seen"],
        "bins": ["one", "manual"],
        "reward": [[10.0, 5.0, -50.0], [-3.0, -3.0, 2.0]],
        "modes": [[1.0], [0.25, 0.75], [1.0]],
    }
    return SortingModel(
        named("c", 3), named("v", k), rng.dirichlet(np.ones(2), size=(h, k, 4)), **keys | settings
    )


def class_of_kinds(model: SortingModel) -> list[int]:
    """The class of each of the N kinds."""
    return [label for label, weights in enumerate(model.modes) for _ in weights]


def arrival_of_kinds(model: SortingModel) -> list[float]:
    """The distribution of the kind of an arriving object."""
    return [p * w for p, weights in zip(model.arrival, model.modes, strict=True) for w in weights]


def random_belief(model: SortingModel, seed: int) -> Belief:
    rows = np.random.default_rng(seed).dirichlet(np.ones(len(model.classes)), size=model.positions)
    return Belief(model, rows)
