"""A hundred kills of a batch of ten, at every kind of moment."""

from pathlib import Path

import pytest

from tests.account import Account
from tests.sorting.killed_run import OBJECTS, FileWorld, run
from tests.sorting.test_resume import check_as_if_uninterrupted, killed, points

KILLS, SEED = 100, 2019


@pytest.mark.soak
def test_a_hundred_kills(tmp_path: Path, account: Account) -> None:
    whole = tmp_path / "whole"
    whole.mkdir()
    expected = run(whole, "never", resume=False)
    for number, point in enumerate(points(whole, KILLS, SEED)):
        folder = tmp_path / str(number)
        folder.mkdir()
        account.injected("own process")
        killed(folder, point)
        report = run(folder, "never", resume=True)
        account.lost("own process", abs(OBJECTS - len(FileWorld(folder / "world.sqlite").acts("sort"))))
        check_as_if_uninterrupted(folder, report, expected)
