"""The measurement of moving belts counts what happens, and goes on where it ended."""

from collections import Counter
from pathlib import Path

import pytest

from beltsort.perception import Perception
from beltsort.sim import CellConfig
from beltsort.sim.prepare import prepare
from benchmarks.moving_belt import MEASURES, STOPPING, Belt, Circumstance, append, circumstances, lines, read


@pytest.mark.parametrize("circumstance", [STOPPING, Circumstance(0.5, 0.1)])
def test_a_short_belt_is_counted(circumstance: Circumstance) -> None:
    counts = Belt(circumstance, 1, 2).run(Perception(CellConfig().layout, prepare().database))
    assert 1 <= counts["objects"] <= 2
    assert counts["due"] >= counts["found"] >= counts["labelled"] >= counts["right"]
    assert counts["found"] >= 1
    assert counts["confused"] == counts["untracked"] == 0
    assert set(counts) <= set(MEASURES)


def test_counts_are_kept_and_printed(tmp_path: Path) -> None:
    file = tmp_path / "counts.csv"
    for here in (STOPPING, Circumstance(0.2, 0.1, 1.01, 0.002, corrected=False)):
        for number, right in ((0, 30), (1, 36)):
            append(
                file, Belt(here, number, 3, Counter(due=50, labelled=40, found=45, right=right, lost=number))
            )
    rows = read(file)
    assert list(rows) == [STOPPING, Circumstance(0.2, 0.1, 1.01, 0.002, corrected=False)]
    assert rows[STOPPING][1]["right"] == 36
    _, stopping, moving = lines(rows)
    assert "82.5 ± 7.5 %" in stopping
    assert "0.0 ± 0.0 %" in moving
    assert moving.endswith("0 0 0 0 0 1 0")


def test_nothing_is_measured_twice() -> None:
    assert len(set(circumstances())) == len(list(circumstances()))
    assert {here.speed for here in circumstances()} == {0.0, 0.05, 0.1, 0.2, 0.5}
