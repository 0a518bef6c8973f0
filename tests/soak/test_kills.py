"""A hundred kills of a batch of ten, at every kind of moment."""

import subprocess
import sys
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from beltsort.sorting.holds import Answer, Hold
from beltsort.sorting.journal import read_journal
from beltsort.sorting.report import SortingReport
from tests.account import Account
from tests.drivers.ros2.rig import Rig, require_ros2
from tests.soak import ros2_run
from tests.sorting.killed_run import OBJECTS, FileWorld, run
from tests.sorting.test_resume import KILLED, check_as_if_uninterrupted, killed, points
from tests.waiting import wait_until

KILLS, SEED = 100, 2019
AT_ONCE = 3
"""Runs over ROS 2 side by side: they wait most of the time."""


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


@pytest.mark.soak
def test_a_hundred_kills_over_ros2(tmp_path: Path, account: Account) -> None:
    require_ros2()
    whole = tmp_path / "whole"
    whole.mkdir()
    expected, world, _ = ran_over_ros2(whole, "never")
    assert world.total() == OBJECTS

    def ran(numbered: tuple[int, str]) -> tuple[str, SortingReport, Counter[int], int]:
        number, point = numbered
        folder = tmp_path / str(number)
        folder.mkdir()
        return (point, *ran_over_ros2(folder, point))

    moments, asked = moments_of(whole), 0
    with ThreadPoolExecutor(AT_ONCE) as pool:
        for point, report, bins, questions in pool.map(ran, enumerate(moments)):
            account.injected("own process, Ros2")
            account.lost("own process, Ros2", abs(OBJECTS - bins.total()))
            assert report == expected, point
            assert bins == Counter(decision.label for decision in report.decisions), point
            asked += questions
    kinds = Counter(point.partition(":")[0] for point in moments)
    print(f"\nkilled at {dict(kinds)}; a person was asked {asked} times")


def moments_of(whole: Path) -> list[str]:
    """Moments to be killed at: after an entry of the journal, after a command, and during one."""
    rng = np.random.default_rng(SEED)
    entries = len(read_journal(whole / "journal.sqlite"))
    after_entries = rng.choice(np.arange(1, entries), KILLS - 2 * (KILLS // 3), replace=False)
    commands = [rng.integers(1, 2 * OBJECTS, KILLS // 3, endpoint=True) for _ in ("act", "during")]
    return [
        *(f"entry:{n}" for n in after_entries),
        *(f"act:{n}" for n in commands[0]),
        *(f"during:{n}" for n in commands[1]),
    ]


def ran_over_ros2(folder: Path, point: str) -> tuple[SortingReport, Counter[int], int]:
    """Run to where the run kills itself, and then to its end.

    Returns report, bins, and how often a person was asked: a sorter that has not heard of a command cannot
    tell whether it is still on its way.
    """
    questions: list[Hold] = []

    def looks(hold: Hold) -> Answer:
        assert set(hold.answers) == {Answer.DONE, Answer.NOT_DONE}, hold
        questions.append(hold)
        wait_until(lambda: not rig.tell()["busy"]["sorter"], "the sorter is at rest")
        return Answer.DONE if sum(rig.tell()["bins"]) > (hold.object or 0) else Answer.NOT_DONE

    with closing(Rig(folder)) as rig:
        if point != "never":
            arguments = [sys.executable, "-m", "tests.soak.ros2_run", str(folder), str(rig.domain), point]
            assert subprocess.run(arguments, check=False).returncode == KILLED
        report = ros2_run.run(folder, rig.domain, "never", resume=point != "never", operator=looks)
        world = rig.tell()
    assert world["object"] == OBJECTS
    return report, +Counter(dict(enumerate(world["bins"]))), len(questions)
