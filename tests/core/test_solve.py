import itertools

import pytest

from beltsort import ArgumentError, Belief, Decide, Move, SortingModel, Threshold, evaluate, solve

PAPER = SortingModel.load("tests/fixtures/paper.json")


def test_one_position_is_solved() -> None:
    # The optimum of the paper's first position alone lies in [17.496, 17.500] (SARSOP, two minutes).
    solution = solve(PAPER.with_positions(1), seconds=20)
    assert 17.49 < solution.lower <= solution.upper < 17.51
    assert solution.seconds < 25


def test_bounds_tighten_and_enclose_what_a_policy_earns() -> None:
    heard: list[tuple[float, float]] = []
    solution = solve(PAPER, seconds=3, progress=lambda lower, upper: heard.append((lower, upper)))
    assert len(heard) > 3
    for (lower, upper), (later_lower, later_upper) in itertools.pairwise(heard):
        assert lower <= later_lower
        assert later_upper <= upper
    # Batches so long that what comes after is discounted away.
    earned = evaluate(PAPER, solution, batches=300, batch_size=60).summary()["expected_discounted_returns"]
    simple = evaluate(PAPER, Threshold(PAPER, 0.94), batches=300, batch_size=60).summary()
    assert earned["mean"] < solution.upper + 3 * earned["standard_error"]
    assert earned["mean"] > simple["expected_discounted_returns"]["mean"], "the same objects, a better policy"


def test_bounds_elsewhere_and_actions() -> None:
    solution = solve(PAPER, seconds=1)
    certain = Belief(PAPER, [[0.0, 1.0, 0.0, 0.0], [0.25] * 4])
    lower, upper = solution.bounds(certain)
    assert solution.lower < lower <= upper
    assert solution.act(certain, 0) == Decide(1)
    assert isinstance(solution.act(Belief(PAPER), 0), Move)


def test_what_progress_raises_ends_the_solver() -> None:
    def enough(lower: float, upper: float) -> None:
        raise RuntimeError(f"enough: {lower < upper}")

    with pytest.raises(RuntimeError, match="enough: True"):
        solve(PAPER, seconds=600, progress=enough)


@pytest.mark.parametrize("seconds", [0, -1, float("nan"), float("inf")])
def test_a_time_must_be_above_zero(seconds: float) -> None:
    with pytest.raises(ArgumentError, match="finite time above 0"):
        solve(PAPER, seconds=seconds)


def test_a_belief_of_another_model_is_refused() -> None:
    solution = solve(PAPER.with_positions(1), seconds=0.5)
    with pytest.raises(ArgumentError, match="another model"):
        solution.bounds(Belief(PAPER))
