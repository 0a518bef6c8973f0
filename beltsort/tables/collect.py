"""Drive simulated cells through scans of every class at every viewpoint and position.

Every count is an object drawn for it alone: a *round* at one viewpoint is L scenes in which each class stands
once at each position, and every scene is a new cell with a seed of its own. So the result is a function of
the seed, whatever the number of processes.
"""

import os
import signal
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from functools import partial
from multiprocessing import get_context
from typing import TypeVar

import numpy as np

import beltsort
from beltsort.cell.protocols import Scan
from beltsort.cell.simulated import CellConfig
from beltsort.cell.simulated.randomness import checked_seed, generator
from beltsort.perception import NearestNeighbour, Perception, PerceptionConfig, describe, segment
from beltsort.perception.vfh import Histogram
from beltsort.tables.counts import Counts, Look, count

Progress = Callable[[int, int], None]
Result = TypeVar("Result")

TRAINING_STREAM, TABLE_STREAM = 0, 1  # no object is both trained on and counted


@dataclass(frozen=True)
class Round:
    """L scenes at one viewpoint, in which every class stands once at every position."""

    stream: int
    seed: int
    viewpoint: int
    number: int

    def scenes(self, config: CellConfig, scans: int) -> Iterator[tuple[list[int], list[Scan]]]:
        """Yield the true classes of each scene, the belt end first, and `scans` scans of it."""
        from beltsort.cell.simulated import SimulatedCell

        rng = generator(self.seed, self.stream, self.viewpoint, self.number)
        cups, classes = config.layout.positions + config.upstream, len(config.classes)
        arrangement = np.stack([rng.permutation(classes) for _ in range(cups)])  # (cups, L)
        for scene in range(classes):
            true = [int(label) for label in arrangement[:, scene]]
            cell = SimulatedCell(true, config, seed=int(rng.integers(2**63)))
            stop = cell.move_to(self.viewpoint, "move")
            yield true, [cell.scan(not_before=stop) for _ in range(scans)]


def at_least_one(name: str, number: int) -> int:
    """Return `number`, or raise an `ArgumentError` about `name` if it is below 1."""
    if number < 1:
        raise beltsort.ArgumentError(f"{name} is {number}, expected at least 1; give a positive number")
    return number


def _rounds(stream: int, seed: int, config: CellConfig, objects: int) -> list[Round]:
    at_least_one("objects", objects)
    viewpoints = range(len(config.viewpoints))
    return [Round(stream, checked_seed(seed), k, number) for number in range(objects) for k in viewpoints]


def collect_training(
    config: CellConfig | None = None,
    perception: PerceptionConfig | None = None,
    *,
    objects: int = 40,
    seed: int = 0,
    workers: int | None = None,
    progress: Progress | None = None,
) -> NearestNeighbour:
    """Train a classifier on objects of the simulated cell.

    The processes are spawned and import the main module again: a script calls this under
    `if __name__ == "__main__":`.

    Parameters
    ----------
    config, perception
        What the cell and perception are set to.
    objects
        Objects of each class at each viewpoint and position. Too few and rare poses have no neighbour; the
        time grows in proportion.
    seed
        Not negative. `collect_counts` with the same seed draws other objects.
    workers
        Processes, at least 1; default one for each core that this process may use. With 1 the work is done in
        this process.
    progress
        Called with the number of rounds done and in all.

    Returns
    -------
    NearestNeighbour
        Up to K * H * L * `objects` descriptors; objects that perception does not find are left out.

    Raises
    ------
    ArgumentError
        If `objects` or `workers` is below 1.
    BeltsortError
        If a worker process dies.
    """
    config, perception = config or CellConfig(), perception or PerceptionConfig()
    rounds = _rounds(TRAINING_STREAM, seed, config, objects)
    described = _in_processes(partial(_described, config, perception), rounds, workers, progress)
    rows = [row for part in described for row in part]
    return NearestNeighbour.train(
        [descriptor for _, descriptor in rows], [label for label, _ in rows], config.classes, perception
    )


def _described(config: CellConfig, perception: PerceptionConfig, work: Round) -> list[tuple[int, Histogram]]:
    """Return true class and descriptor of every object of a round that is found well."""
    found = []
    for true, (scan,) in work.scenes(config, scans=1):
        segmented = segment(scan, config.layout, perception)
        for label, points in zip(true[: config.layout.positions], segmented.objects, strict=True):
            if points is not None:
                found.append((label, describe(points, segmented.camera, perception)))
    return found


def collect_counts(
    database: NearestNeighbour,
    config: CellConfig | None = None,
    *,
    objects: int = 100,
    seed: int = 0,
    workers: int | None = None,
    progress: Progress | None = None,
) -> Counts:
    """Count the labels of independent objects in every table row.

    As with `collect_training`, a script calls this under `if __name__ == "__main__":`.

    Parameters
    ----------
    database
        The classifier, with the perception settings that it was trained with.
    config
        What the cell is set to.
    objects
        Objects in each row (position, viewpoint, true class), each scanned twice. An entry p has the standard
        error sqrt(p (1 - p) / objects).
    seed, workers, progress
        As in `collect_training`.

    Raises
    ------
    ArgumentError
        If `objects` or `workers` is below 1.
    BeltsortError
        If a worker process dies.
    """
    config = config or CellConfig()
    rounds = _rounds(TABLE_STREAM, seed, config, objects)
    looks = _in_processes(partial(_labelled, config, database), rounds, workers, progress)
    every = (look for part in looks for look in part)
    return count(every, config.layout.positions, len(config.viewpoints), len(config.classes))


def _labelled(config: CellConfig, database: NearestNeighbour, work: Round) -> list[Look]:
    """Return one look, scanned twice, at every object of a round."""
    perceive = Perception(config.layout, database)
    looks = []
    for true, scans in work.scenes(config, scans=2):
        first, second = (perceive(scan) for scan in scans)
        looks += [
            Look(a.position, work.viewpoint, true[a.position], a.label, b.label)
            for a, b in zip(first, second, strict=True)
        ]
    return looks


def _in_processes(
    task: Callable[[Round], Result], rounds: list[Round], workers: int | None, progress: Progress | None
) -> list[Result]:
    """Return the results in order."""
    workers = _cores() if workers is None else at_least_one("workers", workers)
    if workers == 1:
        return _reported(map(task, rounds), len(rounds), progress)
    pool = _pool(workers)
    try:
        return _reported(pool.map(task, rounds, chunksize=2), len(rounds), progress)
    except BrokenProcessPool:
        raise beltsort.BeltsortError(
            f"a worker process died, expected {workers} to live: if memory ran out, give fewer workers; "
            'a script must guard its main module by `if __name__ == "__main__":`'
        ) from None
    finally:
        pool.shutdown(cancel_futures=True)


def _pool(workers: int) -> ProcessPoolExecutor:
    """Return a pool of spawned processes (Open3D hangs in forked ones) that leave Ctrl-C to this one."""
    return ProcessPoolExecutor(
        workers,
        mp_context=get_context("spawn"),
        initializer=signal.signal,
        initargs=(signal.SIGINT, signal.SIG_IGN),
    )


def _cores() -> int:
    """Return the number of cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _reported(results: Iterable[Result], total: int, progress: Progress | None) -> list[Result]:
    done = []
    for result in results:
        done.append(result)
        if progress is not None:
            progress(len(done), total)
    return done
