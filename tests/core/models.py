"""Models to test with."""

from pathlib import Path
from typing import Any

import numpy as np

from beltsort import Belief, SortingModel

PAPER = Path(__file__).parent.parent / "fixtures" / "paper.json"


def named(prefix: str, count: int) -> list[str]:
    return [f"{prefix}{i}" for i in range(count)]


def random_model(seed: int, h: int = 2, k: int = 2, l: int = 3, **settings: Any) -> SortingModel:  # noqa: E741
    p_obs = np.random.default_rng(seed).dirichlet(np.ones(l), size=(h, k, l))
    return SortingModel(named("c", l), named("v", k), p_obs, **settings)


def seeing_model(h: int = 1, k: int = 1, l: int = 3, **settings: Any) -> SortingModel:  # noqa: E741
    """Every look tells the class."""
    return SortingModel(named("c", l), named("v", k), np.tile(np.eye(l), (h, k, 1, 1)), **settings)


def random_belief(model: SortingModel, seed: int) -> Belief:
    rows = np.random.default_rng(seed).dirichlet(np.ones(len(model.classes)), size=model.positions)
    return Belief(model, rows)
