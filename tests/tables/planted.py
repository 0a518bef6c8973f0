"""Looks drawn from planted modes."""

import numpy as np

from beltsort.tables.modes import ModeTables
from beltsort.tables.repeated_looks import Array, LooksAtObject, RepeatedLooks, TableShape

SHAPE = TableShape(positions=2, viewpoints=2, classes=2, labels=3)
WEIGHTS = ((0.6, 0.4), (0.7, 0.3))
_ONE_POSITION = [
    # class 0: its second mode looks like class 1; class 1: its second mode gets the third label.
    [[0.85, 0.10, 0.05], [0.20, 0.70, 0.10], [0.10, 0.80, 0.10], [0.15, 0.10, 0.75]],
    [[0.70, 0.10, 0.20], [0.10, 0.65, 0.25], [0.25, 0.70, 0.05], [0.30, 0.15, 0.55]],
]
P_OBS: Array = np.array([_ONE_POSITION, np.roll(_ONE_POSITION, 1, axis=0)])  # (H, K, N, Z)
TRUTH = ModeTables(WEIGHTS, P_OBS, np.full(4, np.nan), ((), ()))


def planted_objects(
    number: int, scans: int, seed: int = 0, *, named: bool = False, p_obs: Array = P_OBS
) -> list[LooksAtObject]:
    """Draw objects of each class in turn, looked at `scans` times in every row, in a random order."""
    rng = np.random.default_rng(seed)
    objects = []
    for n in range(number):
        true = n % 2
        mode = int(rng.random() >= WEIGHTS[true][0])
        rows = rng.permutation([(j, k) for j in range(2) for k in range(2) for _ in range(scans)]).tolist()
        looks = tuple((j, k, int(rng.choice(3, p=p_obs[j, k, 2 * true + mode]))) for j, k in rows)
        objects.append(LooksAtObject(true, looks, f"mode {mode}" if named else None))
    return objects


def planted(number: int, scans: int, seed: int = 0, *, named: bool = False) -> RepeatedLooks:
    """Draw looks at planted objects."""
    return RepeatedLooks.of(planted_objects(number, scans, seed, named=named), SHAPE)
