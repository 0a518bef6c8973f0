"""Folders of clouds to train on."""

from pathlib import Path

import numpy as np

from beltsort.geometry import Points

SHAPES = {"long": (0.02, 0.02, 0.06), "round": (0.035, 0.035, 0.035)}
CENTRE = np.array([0.0, 0.0, 0.7])  # metres in front of a camera at the origin


def cloud(name: str, seed: int, n: int = 4000) -> Points:
    """Return the near side of an ellipsoid, camera frame."""
    rng = np.random.default_rng([len(name), seed])
    unit = rng.normal(size=(n, 3))
    unit[:, 2] = -np.abs(unit[:, 2])
    unit /= np.linalg.norm(unit, axis=1, keepdims=True)
    seen: Points = unit * np.roll(SHAPES[name], 1) * rng.normal(1.0, 0.02) + CENTRE
    return seen


def cloud_folder(folder: Path, each: int = 3) -> Path:
    """Write clouds of every class and return the folder."""
    for name in SHAPES:
        (folder / name).mkdir(parents=True)
        for seed in range(each):
            np.save(folder / name / f"{seed}.npy", cloud(name, seed))
    return folder
