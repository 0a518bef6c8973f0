"""Speed of planning and simulation, called from Python."""

import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from beltsort import Belief, Despot, SortingModel, Threshold, compare, evaluate
from beltsort.models import paper

BATCHES = 1000


@pytest.fixture(scope="module")
def model() -> SortingModel:
    return paper()


@pytest.mark.parametrize("scenarios", [512, 4096])
def test_plan(benchmark: BenchmarkFixture, model: SortingModel, scenarios: int) -> None:
    planner, belief = Despot(model, scenarios=scenarios, trials=50), Belief(model)
    assert benchmark(planner.plan, belief).trials == 50


def test_observe(benchmark: BenchmarkFixture, model: SortingModel) -> None:
    belief = Belief(model)
    benchmark(belief.observe, 1, [1, None])


def test_evaluate(benchmark: BenchmarkFixture, model: SortingModel) -> None:
    result = benchmark(evaluate, model, Threshold(model, 0.94), batches=BATCHES)
    assert len(result.steps) == BATCHES


def test_compare(benchmark: BenchmarkFixture, model: SortingModel) -> None:
    policies = {f"threshold:{t}": Threshold(model, t) for t in (0.94, 0.9)}
    comparison = benchmark(compare, model, policies, batches=BATCHES)
    assert comparison.baseline == "threshold:0.94"
