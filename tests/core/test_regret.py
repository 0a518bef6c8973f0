"""Regret against a solution: what actions lose."""

import numpy as np
import pytest

from beltsort import (
    ArgumentError,
    InformationGain,
    OneObject,
    Policy,
    Solution,
    SortingModel,
    Threshold,
    compare,
    evaluate,
    solve,
)

from .models import random_model
from .solving import solved_until, within

LONG = 80  # decisions, at least two steps each; what comes later is discounted away


@pytest.fixture(scope="module")
def solution(paper: SortingModel) -> Solution:
    return solved_until(within(0.005), paper.with_positions(1))


@pytest.mark.slow
@pytest.mark.parametrize("threshold", [0.8, 0.97, 0.999])
def test_regret_is_what_a_policy_falls_short_of_the_optimum(solution: Solution, threshold: float) -> None:
    model = solution.model
    result = evaluate(
        model, Threshold(model, threshold), batches=400, batch_size=LONG, seed=1, reference=solution
    )
    short = solution.upper - result.expected_discounted_returns
    unexplained = short - result.discounted_regrets
    error = unexplained.std(ddof=1) / np.sqrt(len(unexplained))
    assert abs(unexplained.mean()) < 4 * error + 0.01
    assert result.discounted_regrets.mean() > 0.01


def test_the_solution_itself_loses_nothing_and_others_do(solution: Solution) -> None:
    model = solution.model
    policies: dict[str, Policy] = {
        "solution": solution,
        "one": OneObject(model),
        "gain": InformationGain(model, 0.9),
    }
    result = compare(model, policies, batches=50, metrics=["regrets"], reference=solution)
    assert result.outcomes("solution", "regrets").max() == 0.0
    assert result.difference("gain", "regrets").mean > 0.1


def test_without_a_reference_there_is_no_regret(solution: Solution) -> None:
    result = evaluate(solution.model, solution, batches=2)
    assert "regrets" not in result.summary()
    with pytest.raises(ArgumentError, match=r"reference=beltsort\.solve"):
        _ = result.regrets


def test_a_reference_that_cannot_judge_is_refused(solution: Solution, paper: SortingModel) -> None:
    with pytest.raises(ArgumentError, match=r"solution.*model.*p_obs"):
        evaluate(paper, Threshold(paper, 0.9), batches=2, reference=solution)
    cheap = solution.model.replace(r_min=5)
    with pytest.raises(ArgumentError, match=r"r_min.*\b50\b.*\b5\b"):
        evaluate(cheap, Threshold(cheap, 0.9), batches=2, reference=solution)
    wide = random_model(0, h=3, k=1, n=2)
    with pytest.raises(ArgumentError, match=r"solution.*two positions"):
        evaluate(wide, Threshold(wide, 0.9), batches=2, reference=solve(wide, seconds=0.2))
