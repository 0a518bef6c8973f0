"""How many objects a minute the cell of a cell file sorts on a belt that never stops, from depth scans.

It is the study of `beltsort.planning.throughput` with labels that are not drawn from tables: the simulated
cell renders scans, in which objects are found, tracked and labelled, and the sorting loop decides.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from beltsort import MovingBelt
from beltsort.cellfile.description import CellDescription
from beltsort.cellfile.ingredients import known_model, model_and_classifier
from beltsort.cellfile.simulated import options_of_cell
from beltsort.cellfile.sorted_belt import (
    SimulatedBelt,
    SortedBelt,
    belt_and_policy,
    simulated_moving,
    sort_belt,
)
from beltsort.planning.bins import Counts, Floats
from beltsort.planning.decisions import right_bins
from beltsort.planning.throughput import CELL_OBJECTS, CELL_RUNS, PURITY, Throughput
from beltsort.planning.throughput.study import Simulated, check_study, speed_results
from beltsort.sim.prepare import StageProgress
from beltsort.util.processes import Progress, at_least_one, in_processes


def cell_throughput(
    description: CellDescription,
    policies: Sequence[str],
    speeds: Sequence[float],
    *,
    purity: float = PURITY,
    objects: int = CELL_OBJECTS,
    runs: int = CELL_RUNS,
    seed: int | None = None,
    workers: int | None = None,
    stage: StageProgress | None = None,
    progress: Progress | None = None,
) -> Throughput:
    """Sort simulated belts at several speeds, from depth scans.

    Model, classifier, durations of arm and scans, prices and rules are those of the cell file. For
    stop-and-go the same cell has a belt that stands while the camera looks, and advances by one place in the
    time in which the moving belt passes one; sorting takes no time. All policies get belts with the same
    objects, but a moving belt may have carried on the first of them before it is seen. As with
    `beltsort.sim.collect.collect_training`, a script must call this under `if __name__ == "__main__":`.

    Parameters
    ----------
    description
        The cell file, with [moving]; every device is simulated.
    policies, speeds, purity
        As in `beltsort.planning.throughput.throughput`.
    objects
        Cups of a run, empty ones included.
    runs
        Number of runs of each policy at each speed.
    seed
        Seed of the first run, each further one has the next; default the cell file's.
    workers
        Processes, at least 1; default one for each core that this process may use.
    stage
        As `progress` of `beltsort.sim.prepare.prepare`.
    progress
        Called with the number of runs done and their total number.

    Raises
    ------
    CellFileError
        If the cell cannot be simulated, or its belt stops.
    ArgumentError
        As `beltsort.planning.throughput.throughput`.
    BeltsortError
        If a run fails.
    """
    check_study(policies, speeds, purity)
    at_least_one("objects", objects)
    at_least_one("runs", runs)
    moving = simulated_moving(description)
    times = moving.times
    at_speeds = [
        moving.model_copy(update={"ticks_per_place": times.ticks_per_place(speed)}) for speed in speeds
    ]
    model, description = known_model(description, None)
    model, classifier = model_and_classifier(description, model, stage)
    first = options_of_cell(description).seed if seed is None else seed
    cells = [description.model_copy(update={"moving": each}) for each in at_speeds]
    points = [
        (name, each, belt_and_policy(each, name, model)[0]) for each, name in product(cells, policies)
    ]  # before anything is simulated: a name may be wrong
    work = [
        SimulatedBelt(each, name, objects, first + run, model, classifier)
        for name, each, _ in points
        for run in range(runs)
    ]
    found = list(in_processes(sort_belt, work, workers, progress))
    every = (
        _simulated(name, belt, found[n * runs : (n + 1) * runs]) for n, (name, _, belt) in enumerate(points)
    )
    return Throughput(tuple(speed_results(every, times.tick)), times, purity, objects, runs, first)


def _simulated(name: str, belt: MovingBelt, belts: Sequence[SortedBelt]) -> Simulated:
    assert belt.ticks_per_place is not None
    plan_seconds = [seconds for each in belts for seconds in each.plan_seconds]
    return Simulated(name, belt.ticks_per_place, SortedBelts(belt, belts), plan_seconds)


@dataclass(frozen=True, eq=False)
class SortedBelts:
    """Runs of a cell, as statistics need them: `beltsort.planning.moving.MovingRuns`.

    Attributes
    ----------
    belt
        Gives rewards and prices.
    belts
        What each run came to.
    """

    belt: MovingBelt
    belts: Sequence[SortedBelt]

    @property
    def confusion(self) -> Counts:
        """Objects by bin and true class, shape (runs, B, L)."""
        return np.array([each.confusion for each in self.belts])

    @property
    def missed(self) -> Counts:
        """Objects that came into no bin, by true class, shape (runs, L)."""
        return np.array([each.missed for each in self.belts])

    @property
    def right(self) -> Counts:
        """Objects in a bin than which none is worth more for their class."""
        return np.asarray((self.confusion * right_bins(self.belt.model)).sum(axis=(1, 2)))

    @property
    def wrong(self) -> Counts:
        """Objects in other bins."""
        return np.asarray(self.confusion.sum(axis=(1, 2)) - self.right)

    @property
    def objects(self) -> Counts:
        """Objects of each run, at least 1."""
        there = self.confusion.sum(axis=(1, 2)) + self.missed.sum(axis=1)
        return np.asarray(np.maximum(np.uint64(1), there))

    @property
    def looks(self) -> Counts:
        """Labels that objects got."""
        return np.array([each.looks for each in self.belts], dtype=np.uint64)

    @property
    def ticks(self) -> Floats:
        """Ticks of each run."""
        return np.array([each.seconds for each in self.belts]) / (self.belt.seconds_per_tick or 1.0)

    @property
    def returns(self) -> Floats:
        """Sum of rewards."""
        decided = (self.confusion * self.belt.model.reward).sum(axis=(1, 2))
        moved = np.array([each.motion_cost for each in self.belts])
        return np.asarray(decided - self.missed @ self.belt.missed - moved)

    @property
    def discounted_returns(self) -> None:
        """Not counted."""
