"""Overhead of the sorting loop besides scans and plans: beliefs, rules, and a durable journal."""

import itertools
from collections.abc import Iterator
from pathlib import Path

import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from beltsort.models import paper
from beltsort.sorting.journal import Journal
from beltsort.sorting.loop import sort_objects
from beltsort.sorting.report import SortingReport
from tests.sorting.scripted_cell import ScriptedCell, scripted
from tests.sorting.test_sorter import LookOnceEach

OBJECTS = 50


@pytest.fixture
def paths(tmp_path: Path) -> Iterator[Path]:
    return (tmp_path / f"{number}.sqlite" for number in itertools.count())


def test_planner_steps(benchmark: BenchmarkFixture, paths: Iterator[Path]) -> None:
    model = paper()

    def run() -> SortingReport:
        with Journal(next(paths)) as journal:
            return sort_objects(
                ScriptedCell(model),
                scripted(itertools.repeat([1, 0])),
                LookOnceEach(),
                model,
                journal,
                objects=OBJECTS,
            )

    assert benchmark(run).steps == 2 * OBJECTS
