"""Measurement of planning speed."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import TypeVar

import numpy as np

from beltsort import ArgumentError, Belief, Despot, SortingModel
from beltsort._core import BUILD_PROFILE
from beltsort.util.machine import peak_memory, processor_name, processors

T = TypeVar("T")

SCENARIOS = 4096
TRIALS = 100
DEADLINE = 0.001  # seconds
FEWEST = 3  # repetitions, however short the time


@dataclass(frozen=True)
class Throughput:
    """Plans of the same work on some threads.

    Attributes
    ----------
    threads
        Threads of the planner.
    plans, expansions, scenario_steps
        Per second: plans, nodes expanded in them, and (scenario, move) pairs simulated in them.
    speed_up
        Over one thread, in the same run.
    """

    threads: int
    plans: float
    expansions: float
    scenario_steps: float
    speed_up: float


@dataclass(frozen=True)
class Overshoot:
    """By how many seconds plans with a deadline missed it.

    Attributes
    ----------
    deadline
        In seconds.
    plans
        How many were made.
    p50, p99
        Median and 99th percentile, in seconds.
    """

    deadline: float
    plans: int
    p50: float
    p99: float


@dataclass(frozen=True)
class Bench:
    """What was measured, and on what.

    Attributes
    ----------
    processor
        Its model.
    processors
        How many this process may use.
    build_profile
        ``release``, or ``debug``, whose numbers mean nothing.
    trials, scenarios
        Of each plan whose throughput was measured.
    throughput
        By number of threads, ascending.
    overshoot
        Of plans with a deadline, on all threads.
    peak_memory
        Largest resident memory of the process, in bytes.
    """

    processor: str
    processors: int
    build_profile: str
    trials: int
    scenarios: int
    throughput: tuple[Throughput, ...]
    overshoot: Overshoot
    peak_memory: int


def run_bench(model: SortingModel, seconds: float) -> Bench:
    """Measure how fast a model is planned for.

    Parameters
    ----------
    model
        The model.
    seconds
        Time to spend, about; three plans of each kind are made however short it is.

    Raises
    ------
    ArgumentError
        If `seconds` is not a finite time above 0.
    """
    checked_seconds(seconds)
    return Bench(
        processor=processor_name(),
        processors=processors(),
        build_profile=BUILD_PROFILE,
        trials=TRIALS,
        scenarios=SCENARIOS,
        throughput=throughput(model, thread_counts(processors()), 0.7 * seconds),
        overshoot=overshoot(model, 0.3 * seconds),
        peak_memory=peak_memory(),
    )


def checked_seconds(seconds: float) -> None:
    """Raise an `ArgumentError` if `seconds` is not a finite time above 0."""
    if not 0 < seconds < float("inf"):
        raise ArgumentError(f"seconds = {seconds}; give a finite time above 0, 10 for example")


def thread_counts(most: int) -> list[int]:
    """Return 1, 2, 4 and so on, and `most`."""
    return sorted({most, *(1 << i for i in range(most.bit_length()) if 1 << i <= most)})


def throughput(model: SortingModel, threads: Sequence[int], seconds: float) -> tuple[Throughput, ...]:
    """Time the same plan on each number of threads, the first of which is 1.

    The numbers of threads take turns, so that whatever else the machine does meets them alike; a speed-up is
    the median ratio within a turn.
    """
    belief = Belief(model)
    planners = [Despot(model, scenarios=SCENARIOS, trials=TRIALS, threads=n) for n in threads]
    work, *_ = [planner.plan(belief) for planner in planners]  # the same on any threads; warms up
    turns = np.array(
        repeated(lambda: [_seconds_of(planner, belief) for planner in planners], seconds)
    )  # (turns, threads), seconds
    each = np.median(turns, axis=0)
    speed_ups = np.median(turns[:, :1] / turns, axis=0)
    return tuple(
        Throughput(n, 1 / time, work.expansions / time, work.scenario_steps / time, speed_up)
        for n, time, speed_up in zip(threads, each.tolist(), speed_ups.tolist(), strict=True)
    )


def overshoot(model: SortingModel, seconds: float) -> Overshoot:
    """Plan with a deadline, and see by how much it is missed."""
    planner, belief = Despot(model, seconds=DEADLINE), Belief(model)
    planner.plan(belief)
    missed_by = np.array(repeated(lambda: _seconds_of(planner, belief) - DEADLINE, seconds))
    p50, p99 = np.percentile(missed_by, [50, 99]).tolist()
    return Overshoot(DEADLINE, len(missed_by), p50, p99)


def repeated(measure: Callable[[], T], seconds: float) -> list[T]:
    """Measure until the time is over, at least `FEWEST` times."""
    began = perf_counter()
    results: list[T] = []
    while len(results) < FEWEST or perf_counter() - began < seconds:
        results.append(measure())
    return results


def _seconds_of(planner: Despot, belief: Belief) -> float:
    began = perf_counter()
    planner.plan(belief)
    return perf_counter() - began
