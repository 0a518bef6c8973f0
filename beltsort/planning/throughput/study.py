"""Policies at several belt speeds, on the same objects."""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from beltsort._core import ArgumentError, MovingPlanner, SortingModel, evaluate_moving
from beltsort.planning.bins import Floats
from beltsort.planning.difference import Difference, half_interval, paired_difference
from beltsort.planning.moving import MovingRuns, MovingStatistics, moving_statistics
from beltsort.planning.named_moving_policy import named_moving_policy
from beltsort.planning.throughput.arm import ArmTimes
from beltsort.planning.timed import TimedPlanner
from beltsort.util.text import numbers_or_none

PERCENTILE = 0.99
PURITY = 0.95
"""Purity that is to be held, unless given."""
OBJECTS = 50
"""Objects of a run, likewise."""
RUNS = 60
"""Number of runs, likewise."""
CELL_OBJECTS, CELL_RUNS = 20, 8
"""The same of a cell, whose scans are rendered."""


@dataclass(frozen=True)
class SpeedResult:
    """A policy at a belt speed.

    Attributes
    ----------
    policy
        Its name.
    places_per_minute
        The belt's speed, after rounding to whole ticks; for stop-and-go the speed at which it advances.
    ticks_per_place
        The same in ticks.
    statistics
        Estimates over runs.
    reward_difference
        Reward per object, minus that of the first policy at the same speed; paired by run.
    plan_seconds
        99th percentile of the wall-clock time of a plan in these runs; None for policies that do not search.
    """

    policy: str
    places_per_minute: float
    ticks_per_place: int
    statistics: MovingStatistics
    reward_difference: Difference
    plan_seconds: float | None


@dataclass(frozen=True)
class Held:
    """The most objects a minute that a policy sorts while it holds a purity.

    Attributes
    ----------
    policy
        Its name.
    result
        The result with most objects per minute among those that hold the purity; None if none does.
    by_interval
        Whether the lower end of the 95 % interval of its purity holds the purity too; False without a result,
        and from a single run, which has no interval.
    """

    policy: str
    result: SpeedResult | None
    by_interval: bool


@dataclass(frozen=True)
class Throughput:
    """Results of policies at belt speeds.

    Attributes
    ----------
    results
        One per speed and policy.
    times
        Durations of the cell.
    purity
        The purity that is to be held: by every bin that received an object, as the estimate says.
    objects, runs, seed
        Size and seed of the simulation.
    """

    results: tuple[SpeedResult, ...]
    times: ArmTimes
    purity: float
    objects: int
    runs: int
    seed: int

    @property
    def policies(self) -> list[str]:
        """Names of the policies, in their order."""
        return list(dict.fromkeys(result.policy for result in self.results))

    def of(self, policy: str) -> list[SpeedResult]:
        """Return the results of a policy, in the order of speeds."""
        return [result for result in self.results if result.policy == policy]

    def held(self) -> list[Held]:
        """Return for each policy the most objects per minute at which the purity is held."""
        found = []
        for policy in self.policies:
            best = max(filter(self._holds, self.of(policy)), key=_per_minute, default=None)
            found.append(Held(policy, best, best is not None and self._holds_by_interval(best)))
        return found

    def to_dict(self) -> dict[str, Any]:
        """Return all results as plain data for JSON."""
        return {
            "seconds": vars(self.times),
            "purity": self.purity,
            "objects": self.objects,
            "runs": self.runs,
            "seed": self.seed,
            "results": [_plain(result) for result in self.results],
            "held": {
                held.policy: None
                if held.result is None
                else {**_plain(held.result), "by_interval": held.by_interval}
                for held in self.held()
            },
        }

    def _holds(self, result: SpeedResult) -> bool:
        return result.statistics.least_purity.value >= self.purity

    def _holds_by_interval(self, result: SpeedResult) -> bool:
        found = result.statistics.least_purity
        return found.value - half_interval(found.standard_error) >= self.purity


def throughput(
    model: SortingModel,
    policies: Sequence[str],
    speeds: Sequence[float],
    times: ArmTimes,
    *,
    reach: int | None = None,
    missed: float | None = None,
    purity: float = PURITY,
    objects: int = OBJECTS,
    runs: int = RUNS,
    seed: int = 0,
    folder: Path | None = None,
    progress: Callable[[int, int], object] | None = None,
) -> Throughput:
    """Simulate policies at several belt speeds.

    All of them meet the same objects, and the n-th look at an object has the same random for each of them.
    Policies that search are timed, and run on one thread.

    Parameters
    ----------
    model
        Classes, tables and rewards.
    policies
        Names, as `beltsort.planning.named_moving_policy` explains them.
    speeds
        Belt speeds in places per minute.
    times
        Durations of the cell.
    reach, missed
        As in `ArmTimes.belt`.
    purity
        What `Throughput.held` asks of every bin.
    objects, runs, seed
        As in `evaluate_moving`.
    folder
        Where policies of one's own are found; default: the working folder.
    progress
        Called with the number of simulations done and their total number, first with 0.

    Raises
    ------
    ArgumentError
        For no or repeated policies or speeds, a purity outside (0, 1], or what `evaluate_moving` refuses.

    Examples
    --------
    >>> import beltsort
    >>> words = ["most-urgent:0.9", "stop-and-go:threshold:0.9"]
    >>> found = throughput(beltsort.models.paper(), words, [10, 40], ArmTimes(), objects=10, runs=20)
    >>> [result.ticks_per_place for result in found.of("most-urgent:0.9")]
    [12, 3]
    """
    check_study(policies, speeds, purity)
    total = len(policies) * len(speeds)
    if progress is not None:
        progress(0, total)

    def simulated() -> Iterator[Simulated]:
        for number, (speed, name) in enumerate(product(speeds, policies), start=1):
            belt = times.belt(model, speed, reach, missed)
            own_belt, policy = named_moving_policy(name, belt, folder)
            timed = TimedPlanner(policy) if isinstance(policy, MovingPlanner) else None
            found = evaluate_moving(own_belt, timed or policy, objects=objects, runs=runs, seed=seed)
            yield Simulated(name, times.ticks_per_place(speed), found, timed.seconds if timed else ())
            if progress is not None:
                progress(number, total)

    return Throughput(tuple(speed_results(simulated(), times.tick)), times, purity, objects, runs, seed)


@dataclass(frozen=True)
class Simulated:
    """The runs of a policy at a belt speed.

    Attributes
    ----------
    policy
        Its name.
    ticks_per_place
        The belt's speed; for stop-and-go the one at which it advances.
    runs
        What they came to.
    plan_seconds
        Wall-clock times of plans; none of policies that do not search.
    """

    policy: str
    ticks_per_place: int
    runs: MovingRuns
    plan_seconds: Sequence[float]


def check_study(policies: Sequence[str], speeds: Sequence[float], purity: float) -> None:
    """Check what a study compares.

    Raises
    ------
    ArgumentError
        For no or repeated policies or speeds, or a purity outside (0, 1].
    """
    for what, given in (("policies", policies), ("speeds", speeds)):
        if not given or len(set(given)) < len(given):
            raise ArgumentError(f"{what} = {list(given)}, expected one at least, and each once: correct it")
    if not 0 < purity <= 1:
        raise ArgumentError(f"purity = {purity}, expected a share above 0 and at most 1: correct it")


def speed_results(every: Iterable[Simulated], tick: float) -> Iterator[SpeedResult]:
    """Yield the result of each policy at each speed.

    Parameters
    ----------
    every
        The runs, speed by speed, of the same policies in the same order.
    tick
        Seconds of a tick.
    """
    baseline: tuple[str, Floats] | None = None
    for one in every:
        rewards = one.runs.returns / one.runs.objects
        if baseline is None or baseline[0] == one.policy:
            baseline = one.policy, rewards
        yield SpeedResult(
            one.policy,
            60 / (one.ticks_per_place * tick),
            one.ticks_per_place,
            moving_statistics(one.runs),
            paired_difference(rewards, baseline[1]),
            float(np.quantile(one.plan_seconds, PERCENTILE)) if one.plan_seconds else None,
        )


def _per_minute(result: SpeedResult) -> float:
    found = result.statistics.objects_per_minute
    return math.nan if found is None else found.value


def _plain(result: SpeedResult) -> dict[str, Any]:
    return {
        "policy": result.policy,
        "places_per_minute": result.places_per_minute,
        "ticks_per_place": result.ticks_per_place,
        **result.statistics.to_dict(),
        "reward_difference": numbers_or_none(vars(result.reward_difference)),
        "plan_seconds": result.plan_seconds,
    }
