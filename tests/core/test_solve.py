import itertools
from pathlib import Path

import numpy as np
import pytest

from beltsort import (
    ArgumentError,
    Belief,
    Decide,
    Despot,
    Move,
    Solution,
    SortingModel,
    Threshold,
    evaluate,
    solve,
)

from .models import random_belief, random_model
from .solving import solved_until, within

PAPER = SortingModel.load("tests/fixtures/paper.json")


def test_one_position_is_solved() -> None:
    # The optimum of the paper's first position alone lies in [17.496, 17.500], rounded (SARSOP, two minutes).
    solution = solved_until(within(0.02), PAPER.with_positions(1))
    assert 17.49 < solution.lower <= solution.upper < 17.51
    assert solution.lower <= 17.5
    assert solution.upper >= 17.4955


@pytest.mark.slow
def test_bounds_tighten_and_enclose_what_a_policy_earns() -> None:
    heard: list[tuple[float, float]] = []

    def solved(seconds: float) -> Solution:
        heard.clear()
        return solve(PAPER, seconds=seconds, progress=lambda lower, upper: heard.append((lower, upper)))

    solution = next(found for seconds in (2, 4, 8, 16, 32, 64) if within(4)(found := solved(seconds)))
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
    solution = solved_until(within(10), PAPER)
    certain = Belief(PAPER, [[0.0, 1.0, 0.0, 0.0], [0.25] * 4])
    lower, upper = solution.bounds(certain)
    assert solution.lower < lower <= upper
    assert solution.act(certain, 0) == Decide(1)
    lower, upper = solution.bounds(Belief(PAPER))
    assert solution.lower <= lower <= upper <= solution.upper
    assert isinstance(solution.act(Belief(PAPER), 0), Move)


def test_what_progress_raises_ends_the_solver() -> None:
    def enough(lower: float, upper: float) -> None:
        raise RuntimeError(f"enough: {lower < upper}")

    with pytest.raises(RuntimeError, match="enough: True"):
        solve(PAPER, seconds=600, progress=enough)


@pytest.mark.parametrize("seconds", [0, -1, float("nan"), float("inf")])
def test_a_time_must_be_above_zero(seconds: float) -> None:
    with pytest.raises(ArgumentError, match=rf"(?i)seconds.*{seconds}.*\b0\b"):
        solve(PAPER, seconds=seconds)


def test_a_belief_of_another_model_is_refused() -> None:
    solution = solve(PAPER.with_positions(1), seconds=0.5)
    with pytest.raises(ArgumentError, match=r"belief.*Belief\(policy\.model\)"):
        solution.bounds(Belief(PAPER))


def test_a_loaded_solution_answers_like_the_saved_one(tmp_path: Path) -> None:
    path = tmp_path / "paper.solution"
    saved = solve(PAPER, seconds=0.5)
    saved.save(path)
    loaded = Solution.load(path, PAPER)
    assert (loaded.lower, loaded.upper, loaded.seconds) == (saved.lower, saved.upper, saved.seconds)
    assert loaded.model == PAPER
    for seed in range(20):
        belief = random_belief(PAPER, seed)
        assert loaded.bounds(belief) == saved.bounds(belief)
        assert loaded.act(belief, 0) == saved.act(belief, 0)
    assert list(tmp_path.iterdir()) == [path]


def test_a_solution_of_another_model_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "one.solution"
    model = random_model(1, h=1, r_min=50)
    solve(model, seconds=0.1).save(path)
    other = SortingModel(model.classes, model.viewpoints, model.p_obs, r_min=5)
    with pytest.raises(ArgumentError, match=r"r_min.*\b50\b.*\b5\b"):
        Solution.load(path, other)
    p_obs = np.array(model.p_obs)
    p_obs[0, 1, 2] = [0.2, 0.3, 0.5]
    with pytest.raises(ArgumentError, match=r"p_obs\[0\]\[1\]\[2\]\[0\].*0\.2\b"):
        Solution.load(path, SortingModel(model.classes, model.viewpoints, p_obs))


def test_a_damaged_file_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "damaged.solution"
    solve(random_model(1, h=1), seconds=0.1).save(path)
    content = path.read_bytes()
    path.write_bytes(content[:-100])
    with pytest.raises(ArgumentError, match=r"damaged\.solution.*checksum"):
        Solution.load(path)
    path.write_bytes(content.replace(b"solution 1", b"solution 7", 1))
    with pytest.raises(ArgumentError, match=r"damaged\.solution.*version 7.*\b1\b"):
        Solution.load(path)
    with pytest.raises(ArgumentError, match="Is a directory"):
        Solution.load(tmp_path)


@pytest.mark.slow
def test_a_planner_that_knows_a_solution_plans_with_tighter_bounds(tmp_path: Path) -> None:
    path = tmp_path / "paper.solution"
    belief = Belief(PAPER)
    belief.observe(2, [1, 0])
    alone = Despot(PAPER, trials=20).plan(belief, 2)
    assert alone.certified_upper is not None
    own = alone.certified_upper
    solved_until(lambda solution: solution.bounds(belief, 2)[1] < own, PAPER).save(path)
    solution = Solution.load(path)
    told = Despot(PAPER, trials=20, solution=solution).plan(belief, 2)
    assert told.action == alone.action
    assert told.upper < alone.upper
    assert told.certified_upper is not None
    assert told.certified_upper < own
    assert told.certified_upper <= solution.bounds(belief, 2)[1]
    with pytest.raises(ArgumentError, match=r"r_min.*\b50\b.*\b5\b"):
        Despot(PAPER.replace(r_min=5), solution=solution)
