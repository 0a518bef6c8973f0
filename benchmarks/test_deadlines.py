"""Adherence of plans to their deadlines, and the response time to Ctrl-C."""

import signal
import threading
import time

import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from beltsort import Belief, Despot, SortingModel
from beltsort.models import paper


@pytest.fixture(scope="module")
def model() -> SortingModel:
    return paper()


@pytest.mark.parametrize("seconds", [0.01, 0.05, 0.5])
def test_a_plan_takes_its_time_and_no_more(
    benchmark: BenchmarkFixture, model: SortingModel, seconds: float
) -> None:
    plan = benchmark(Despot(model, seconds=seconds).plan, Belief(model))
    # A search ends where one more trial would not end in time.
    assert 0.9 * seconds <= plan.seconds < 2.0 * seconds


@pytest.mark.parametrize("threads", [1, 4])
def test_control_c_ends_a_plan_soon(benchmark: BenchmarkFixture, model: SortingModel, threads: int) -> None:
    planner = Despot(model, threads=threads)

    def interrupted() -> float:
        """Return the seconds from Ctrl-C to the end of the plan."""
        sent: list[float] = []

        def interrupt() -> None:
            sent.append(time.perf_counter())
            signal.raise_signal(signal.SIGINT)

        timer = threading.Timer(0.2, interrupt)
        timer.start()
        with pytest.raises(KeyboardInterrupt):
            planner.plan(Belief(model), seconds=60.0)
        return time.perf_counter() - sent[0]

    assert benchmark(interrupted) < 1.0
