"""What Ctrl-C and SIGTERM leave of `solve`, and planners that are being made."""

import re
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import beltsort
from tests.interrupting import interrupted

from .running import PAPER

pytestmark = pytest.mark.process


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_solve_keeps_what_it_has(tmp_path: Path, number: signal.Signals) -> None:
    file = tmp_path / "paper.solution"
    command = [sys.executable, "-m", "beltsort", "solve", PAPER, "--seconds", "100000", "-o", str(file)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        try:
            assert process.stderr is not None
            assert re.search(r"<= V\* <=", process.stderr.readline())
            process.send_signal(number)
            told, errors = process.communicate()
        finally:
            process.kill()
    assert process.returncode == 128 + number
    assert "interrupted: what has been found up to now is valid\n" in errors
    assert f"saved as {file}\n" in errors
    model = beltsort.SortingModel.load(PAPER)
    solution = beltsort.Solution.load(file, model)
    bounds = re.fullmatch(r"(\S+) <= V\* <= (\S+) .*\n", told)
    assert bounds is not None
    lower, upper = map(float, bounds.groups())
    assert lower < upper
    assert (solution.lower, solution.upper) == pytest.approx((lower, upper), abs=1e-4)
    value = beltsort.evaluate(model, solution, batches=2).steps
    assert (value > 0).all()


def test_solve_ends_when_it_is_told_to() -> None:
    model = beltsort.models.paper().with_positions(1)
    solution = beltsort.solve(model, seconds=1e5, stop=lambda: True)
    assert solution.lower <= beltsort.solve(model, seconds=1).lower + 1e-9
    assert solution.upper >= beltsort.solve(model, seconds=1).lower


def test_what_stop_raises_passes_through() -> None:
    def stop() -> bool:
        raise LookupError("stop")

    with pytest.raises(LookupError, match="stop"):
        beltsort.solve(beltsort.models.paper(), seconds=1e5, stop=stop)


def many_kinds(kinds: int = 10_368) -> beltsort.SortingModel:
    """Return a model whose planners take hours to make."""
    rng = np.random.default_rng(0)
    p_obs = rng.dirichlet(np.full(4, 0.7), size=(1, 8, kinds))
    classes, viewpoints = [f"class {n}" for n in range(4)], [f"p{n}" for n in range(8)]
    modes = [[4 / kinds] * (kinds // 4)] * 4
    return beltsort.SortingModel(classes, viewpoints, p_obs, labels=classes, modes=modes)


@pytest.mark.parametrize(
    "make",
    [
        beltsort.Despot,
        lambda model: beltsort.Despot(model, variant="scenarios"),
        beltsort.OneObject,
        beltsort.LookAhead,
    ],
    ids=["despot", "scenarios", "one-object", "look-ahead"],
)
def test_planners_of_many_kinds_can_be_interrupted(
    make: Callable[[beltsort.SortingModel], object],
) -> None:
    model = many_kinds()
    with interrupted():
        make(model)
