"""Repeated looks at objects of the simulated cell, with the distance to every class."""

from dataclasses import dataclass
from pathlib import Path
from typing import Self

import numpy as np

from beltsort.perception import NearestNeighbour, segment
from beltsort.sim import CellConfig, SimulatedCell
from beltsort.tables.repeated_looks import NONE, Array, Integers
from beltsort.util.processes import Progress, in_processes
from beltsort.util.randomness import generator

MODES_STREAM = 5  # objects that nothing else uses: see `beltsort.sim.rounds`
RUN_LENGTH = 24  # objects that pass the camera in one simulated cell
SCANS = 2  # from every viewpoint at every position


@dataclass(frozen=True, eq=False)
class SimulatedLooks:
    """Looks at n objects: twice from each of K viewpoints at each of H positions; L classes.

    Attributes
    ----------
    true
        Class indices, shape (n,).
    pose
        How each object lies, shape (n,): 0 upright, 1 leaning, 2 lying. The classifier does not know it.
    labels
        Shape (n, H, K, 2); `NONE` where there was none.
    distances
        Distance to the nearest reference of every class, shape (n, H, K, 2, L); NaN where nothing was found.
    """

    true: Integers
    pose: Integers
    labels: Integers
    distances: Array

    def save(self, path: Path) -> None:
        """Write a .npz file."""
        np.savez_compressed(path, **vars(self))

    @classmethod
    def load(cls, path: Path) -> Self:
        """Read what `save` wrote."""
        with np.load(path, allow_pickle=False) as stored:
            return cls(*(stored[name] for name in ("true", "pose", "labels", "distances")))


@dataclass(frozen=True, eq=False)
class Collector:
    """Scans one run of objects; picklable."""

    database: NearestNeighbour
    config: CellConfig
    seed: int

    def __call__(self, number: int) -> SimulatedLooks:
        """Return the looks at the objects of run `number`: every class is equally frequent in it."""
        config, positions = self.config, self.config.layout.positions
        rng = generator(self.seed, MODES_STREAM, number)
        shown = rng.permutation(np.arange(RUN_LENGTH) % len(config.classes))
        # Objects before and after the ones shown, so that each of these has neighbours at every position.
        before, after = rng.integers(len(config.classes), size=(2, positions + config.upstream))
        before = before[: positions - 1]
        cell_seed = int(rng.integers(2**63))
        cell = SimulatedCell([*before.tolist(), *shown.tolist(), *after.tolist()], config, cell_seed)
        shape = (RUN_LENGTH, positions, len(config.viewpoints), SCANS)
        labels, distances = np.full(shape, NONE), np.full((*shape, len(config.classes)), np.nan)
        for first in range(len(before) + RUN_LENGTH):
            cell.advance_to(first, f"advance-{first}")
            for k in range(len(config.viewpoints)):
                stop = cell.move_to(k, f"move-{first}-{k}")
                for scan in range(SCANS):
                    segmented = segment(cell.scan(not_before=stop), config.layout, self.database.config)
                    for j, points in enumerate(segmented.objects):
                        n = first + j - len(before)
                        if points is None or not 0 <= n < RUN_LENGTH:
                            continue
                        match = self.database.classify(points, segmented.camera)
                        distances[n, j, k, scan] = match.distances
                        labels[n, j, k, scan] = NONE if match.label is None else match.label
        numbers = range(len(before), len(before) + RUN_LENGTH)
        pose = np.array([_pose(config, cell_seed, n) for n in numbers])
        return SimulatedLooks(shown, pose, labels, distances)


def _pose(config: CellConfig, cell_seed: int, number: int) -> int:
    """Return how an object lies: the first random numbers that `beltsort.sim.objects` draws for it."""
    rng = generator(cell_seed, 0, number)
    rng.normal(0.0, config.size_spread, 2)
    mix = np.array([config.poses.upright, config.poses.leaning, config.poses.lying])
    return int(rng.choice(3, p=mix / mix.sum()))


def collect(
    database: NearestNeighbour,
    config: CellConfig,
    *,
    objects: int,
    seed: int = 0,
    workers: int = 1,
    progress: Progress | None = None,
) -> SimulatedLooks:
    """Scan at least `objects` objects, in whole runs of `RUN_LENGTH`; more begin with the same ones."""
    runs = range(-(-objects // RUN_LENGTH))
    parts = list(in_processes(Collector(database, config, seed), runs, workers, progress))
    names = ("true", "pose", "labels", "distances")
    return SimulatedLooks(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))
