"""Random number generators by key, independent of the order of draws."""

import numpy as np

from beltsort.errors import CellError


def checked_seed(seed: int) -> int:
    """Return `seed`, or raise a `CellError` if it is negative."""
    if seed < 0:
        raise CellError(f"seed is {seed}, expected an integer of at least 0; choose another")
    return seed


def generator(seed: int, *key: int) -> np.random.Generator:
    """Return the random number generator of (`seed`, `key`); none of them may be negative."""
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=key))
