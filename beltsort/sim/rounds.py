"""Scenes of the simulated cell that labels are counted in: rounds and passages.

A *round* consists of L scenes at one viewpoint, in which each class is once at each position. Every scene is
a new cell with a seed of its own, so that every count is of an independent object.

A *passage* is one cell past whose camera the belt carries a row of objects: each is seen from every viewpoint
at every position. Counts of different objects are as independent as those of rounds, and the looks at one
object tell how they depend on each other.

Results depend on the seed but not on the number of processes.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from beltsort.cell.protocols import Scan
from beltsort.sim import CellConfig
from beltsort.util.processes import at_least_one
from beltsort.util.randomness import checked_seed, generator

TRAINING_STREAM, TABLE_STREAM, PASSAGE_STREAM = 0, 1, 5
"""Distinct random streams, so that training, tables and passages share no objects; runs have others."""

OBJECTS_OF_A_CLASS = 6  # in a passage: the more, the fewer scans are of objects before and behind them


class SceneTruth(NamedTuple):
    """What one scene is of.

    Attributes
    ----------
    name
        Unique within the stream.
    viewpoint
        Where the camera stands.
    true, objects
        Class and name of the object at each position, the belt end first; both None for one that is not
        counted.
    """

    name: str
    viewpoint: int
    true: tuple[int | None, ...]
    objects: tuple[str | None, ...]


class Scenes(ABC):
    """A piece of work: scenes that one process scans."""

    @abstractmethod
    def truths(self, config: CellConfig) -> list[SceneTruth]:
        """Return what each scene is of, without scanning it."""

    @abstractmethod
    def scans(self, config: CellConfig, number: int) -> Iterator[list[Scan]]:
        """Yield `number` scans of each scene, in the order of `truths`."""

    def scan_names(self, config: CellConfig, scans: int) -> list[str]:
        """Return the name of each scan, `scans` of every scene, in order."""
        return [f"{truth.name}-scan{scan}" for truth in self.truths(config) for scan in range(scans)]


@dataclass(frozen=True)
class Round(Scenes):
    """L scenes at one viewpoint, in which every class is once at every position."""

    stream: int
    seed: int
    viewpoint: int
    number: int

    def truths(self, config: CellConfig) -> list[SceneTruth]:
        """Return what each scene is of."""
        positions = config.layout.positions
        found = []
        for scene, true in enumerate(_arrangement(config, self._generator())):
            name = f"viewpoint{self.viewpoint}-round{self.number:04}-scene{scene}"
            objects = tuple(f"{name}-object{j}" for j in range(positions))
            found.append(SceneTruth(name, self.viewpoint, tuple(true[:positions]), objects))
        return found

    def scans(self, config: CellConfig, number: int) -> Iterator[list[Scan]]:
        """Yield `number` scans of each scene."""
        from beltsort.sim import SimulatedCell

        rng = self._generator()
        for true in _arrangement(config, rng):
            cell = SimulatedCell(true, config, seed=int(rng.integers(2**63)))
            stop = cell.move_to(self.viewpoint, "move")
            yield [cell.scan(not_before=stop) for _ in range(number)]

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


@dataclass(frozen=True)
class Passage(Scenes):
    """A row of objects, `OBJECTS_OF_A_CLASS` of each class, seen at every position from every viewpoint.

    Others stand before and behind them, so that each has neighbours at every position; they have no name.
    """

    seed: int
    number: int

    def truths(self, config: CellConfig) -> list[SceneTruth]:
        """Return what each scene is of."""
        positions, row = config.layout.positions, self._row(config)
        found = []
        for first in range(row.steps):
            seen = [row.number_of(first + j) for j in range(positions)]
            true = tuple(None if n is None else row.true[first + j] for j, n in enumerate(seen))
            objects = tuple(None if n is None else self._name(n) for n in seen)
            for k in range(len(config.viewpoints)):
                name = f"passage{self.number:04}-step{first:02}-viewpoint{k}"
                found.append(SceneTruth(name, k, true, objects))
        return found

    def scans(self, config: CellConfig, number: int) -> Iterator[list[Scan]]:
        """Yield `number` scans of each scene."""
        from beltsort.sim import SimulatedCell

        row = self._row(config)
        cell = SimulatedCell(row.true, config, row.cell_seed)
        for first in range(row.steps):
            cell.advance_to(first, f"advance-{first}")
            for k in range(len(config.viewpoints)):
                stop = cell.move_to(k, f"move-{first}-{k}")
                yield [cell.scan(not_before=stop) for _ in range(number)]

    def poses(self, config: CellConfig) -> dict[str, str]:
        """Return how each object lies by its name, which the classifier does not know."""
        from beltsort.sim.objects import object_generator, pose_name

        row = self._row(config)
        generators = (object_generator(row.cell_seed, row.before + n) for n in range(row.shown))
        return {self._name(n): pose_name(config, rng) for n, rng in enumerate(generators)}

    def _name(self, number: int) -> str:
        return f"passage{self.number:04}-object{number:02}"

    def _row(self, config: CellConfig) -> "_Row":
        positions, classes = config.layout.positions, len(config.classes)
        rng = generator(self.seed, PASSAGE_STREAM, self.number)
        shown = rng.permutation(np.arange(OBJECTS_OF_A_CLASS * classes) % classes).tolist()
        before, behind = rng.integers(classes, size=(2, positions + config.upstream)).tolist()
        before = before[: positions - 1]
        return _Row((*before, *shown, *behind), len(before), len(shown), int(rng.integers(2**63)))


class _Row(NamedTuple):
    """Classes of all objects of a passage, and which of them are shown at every position."""

    true: tuple[int, ...]
    before: int
    shown: int
    cell_seed: int

    @property
    def steps(self) -> int:
        """Number of times that the belt stops."""
        return self.before + self.shown

    def number_of(self, index: int) -> int | None:
        """Return the number of the object at an index of `true` among those that are shown."""
        number = index - self.before
        return number if 0 <= number < self.shown else None


def passages_of(seed: int, objects: int) -> list[Passage]:
    """Return passages with `objects` of each class, rounded up to whole passages."""
    number = -(-at_least_one("objects", objects) // OBJECTS_OF_A_CLASS)
    return [Passage(checked_seed(seed), n) for n in range(number)]
