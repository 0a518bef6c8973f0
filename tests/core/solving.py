"""Solving for as long as this machine needs."""

from collections.abc import Callable

from beltsort import Solution, SortingModel, solve

MOST_SECONDS = 100.0


def solved_until(enough: Callable[[Solution], bool], model: SortingModel, seconds: float = 1.0) -> Solution:
    """Solve with more and more time, until the solution is good enough for what is to be tested."""
    while not enough(solution := solve(model, seconds=seconds)):
        seconds *= 2.0
        assert seconds < MOST_SECONDS, f"not enough yet: [{solution.lower}, {solution.upper}]"
    return solution


def within(gap: float) -> Callable[[Solution], bool]:
    """Bounds at the start that are no further apart."""
    return lambda solution: solution.upper - solution.lower < gap
