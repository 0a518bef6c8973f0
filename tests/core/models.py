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


def random_belief(model: SortingModel, seed: int) -> Belief:
    rows = np.random.default_rng(seed).dirichlet(np.ones(len(model.classes)), size=model.positions)
    return Belief(model, rows)
