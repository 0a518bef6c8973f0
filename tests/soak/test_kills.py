"""A hundred kills of a batch of ten, at every kind of moment."""

from pathlib import Path

import pytest

from tests.loop.killed_run import OBJECTS, run
from tests.loop.test_resume import check_as_if_uninterrupted, killed, points

KILLS, SEED = 100, 2019


@pytest.mark.soak
def test_a_hundred_kills(tmp_path: Path) -> None:
    whole = tmp_path / "whole"
    whole.mkdir()
    expected = run(whole, "never", resume=False)
    for number, point in enumerate(points(whole, KILLS, SEED)):
        folder = tmp_path / str(number)
        folder.mkdir()
        killed(folder, point)
        check_as_if_uninterrupted(folder, run(folder, "never", resume=True), expected)
    print(f"\nkills {KILLS} | survived {KILLS} | objects sorted {KILLS * OBJECTS} | lost 0 | twice 0")
