"""Random numbers that belong to a key, whatever else was drawn."""

import numpy as np

from beltsort.errors import CellError


def checked_seed(seed: int) -> int:
    """Return `seed`, or raise a `CellError` if it is negative."""
    if seed < 0:
        raise CellError(f"seed is {seed}, expected a whole number that is not negative; choose another")
    return seed


def generator(seed: int, *key: int) -> np.random.Generator:
    """Return the generator of `key` under `seed`, none of them negative."""
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=key))
