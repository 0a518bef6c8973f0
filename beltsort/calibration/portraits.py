"""Label single objects from everywhere, to see whether their looks tell as much as independent ones would.

A portrait is all looks at one object as the belt carries it from the last position to the belt end: two from
every viewpoint at every position. The model takes looks for independent given the class, but for repeated
ones from one viewpoint at one position (`repeat`).
"""

from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from beltsort.perception import NearestNeighbour, Perception
from beltsort.sim import CellConfig
from beltsort.sim.collect import SCANS
from beltsort.util.processes import Progress, at_least_one, in_processes
from beltsort.util.randomness import checked_seed, generator

PORTRAIT_STREAM = 3  # neither trained on, nor counted, nor sorted: see `beltsort.sim.rounds`
NO_LABEL = -1

Integers = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Portraits:
    """Labels of n objects in looks of two scans from K viewpoints at H positions.

    Attributes
    ----------
    true
        Class indices, shape (n,).
    labels
        Shape (n, H, K, 2); `NO_LABEL` where there was none.
    """

    true: Integers
    labels: Integers


def collect_portraits(
    database: NearestNeighbour,
    config: CellConfig | None = None,
    *,
    objects: int,
    seed: int = 0,
    workers: int | None = None,
    progress: Progress | None = None,
) -> Portraits:
    """Label objects of the simulated cell, of each class in turn, each among others of random classes.

    Parameters
    ----------
    database
        The classifier.
    config
        What the cell is set to.
    objects
        Number of objects.
    seed, workers, progress
        As in `beltsort.tables.collect_counts`.

    Raises
    ------
    ArgumentError
        If `objects` or `workers` is below 1.
    """
    at_least_one("objects", objects)
    config = config or CellConfig()
    task = partial(_portrait, config, database, checked_seed(seed))
    labels = list(in_processes(task, range(objects), workers, progress))
    return Portraits(np.arange(objects) % len(config.classes), np.array(labels, dtype=np.int64))


def _portrait(config: CellConfig, database: NearestNeighbour, seed: int, number: int) -> Integers:
    """Return the labels of one object, shape (H, K, 2)."""
    from beltsort.sim import SimulatedCell

    positions, rng = config.layout.positions, generator(seed, PORTRAIT_STREAM, number)
    true = rng.integers(len(config.classes), size=2 * positions - 1 + config.upstream).tolist()
    true[positions - 1] = number % len(config.classes)
    cell = SimulatedCell(true, config, int(rng.integers(2**63)))
    perceive = Perception(config.layout, database)
    labels = np.full((positions, len(config.viewpoints), SCANS), NO_LABEL)
    for first in range(positions):
        cell.advance_to(first, f"advance-{first}")
        place = positions - 1 - first
        for k in range(len(config.viewpoints)):
            stop = cell.move_to(k, f"move-{first}-{k}")
            for scan in range(SCANS):
                label = perceive(cell.scan(not_before=stop))[place].label
                labels[place, k, scan] = NO_LABEL if label is None else label
    return labels
