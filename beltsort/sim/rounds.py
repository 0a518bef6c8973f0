"""Rounds of scenes in the simulated cell.

A *round* consists of L scenes at one viewpoint, in which each class is once at each position. Every scene is
a new cell with a seed of its own, so that every count is of an independent object, and results depend on the
seed but not on the number of processes.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from beltsort.cell.protocols import Scan
from beltsort.sim import CellConfig
from beltsort.util.processes import at_least_one
from beltsort.util.randomness import checked_seed, generator

TRAINING_STREAM, TABLE_STREAM = 0, 1  # distinct random streams, so training and tables share no objects


@dataclass(frozen=True)
class Round:
    """L scenes at one viewpoint, in which every class is once at every position."""

    stream: int
    seed: int
    viewpoint: int
    number: int

    def scenes(self, config: CellConfig, scans: int) -> Iterator[tuple[list[int], list[Scan]]]:
        """Yield the true classes of each scene, the belt end first, and `scans` scans of it."""
        from beltsort.sim import SimulatedCell

        rng = self._generator()
        for true in _arrangement(config, rng):
            cell = SimulatedCell(true, config, seed=int(rng.integers(2**63)))
            stop = cell.move_to(self.viewpoint, "move")
            yield true, [cell.scan(not_before=stop) for _ in range(scans)]

    def true_classes(self, config: CellConfig) -> list[list[int]]:
        """Return the true classes of each scene without scanning it, visible positions only."""
        return [true[: config.layout.positions] for true in _arrangement(config, self._generator())]

    def scene_name(self, scene: int) -> str:
        """Return the name of a scene, unique within the stream."""
        return f"viewpoint{self.viewpoint}-round{self.number:04}-scene{scene}"

    def scan_names(self, config: CellConfig, scans: int) -> list[str]:
        """Return the name of each scan, `scans` of every scene, in the order of `scenes`."""
        return [
            f"{self.scene_name(scene)}-scan{scan}"
            for scene in range(len(config.classes))
            for scan in range(scans)
        ]

    def object_names(self, config: CellConfig, scene: int) -> tuple[str, ...]:
        """Return the name of the object at each position."""
        return tuple(f"{self.scene_name(scene)}-object{j}" for j in range(config.layout.positions))

    def _generator(self) -> np.random.Generator:
        return generator(self.seed, self.stream, self.viewpoint, self.number)


def rounds_of(stream: int, seed: int, config: CellConfig, objects: int) -> list[Round]:
    """Return the rounds in which each class is `objects` times at each viewpoint and position."""
    at_least_one("objects", objects)
    viewpoints = range(len(config.viewpoints))
    return [Round(stream, checked_seed(seed), k, number) for number in range(objects) for k in viewpoints]


def _arrangement(config: CellConfig, rng: np.random.Generator) -> list[list[int]]:
    """Draw the true classes of each scene of a round, including cups upstream of the last position."""
    cups, classes = config.layout.positions + config.upstream, len(config.classes)
    columns = np.stack([rng.permutation(classes) for _ in range(cups)])  # (cups, L)
    return [[int(label) for label in columns[:, scene]] for scene in range(classes)]
