"""The engine: rows are the points', whatever the processes, and none is lost or made twice."""

import random
from pathlib import Path

import pytest

import beltsort
from beltsort.errors import SweepError
from beltsort.sweep import engine
from beltsort.sweep.engine import RowStore, attempt, run_points, version
from tests.sweep import tasks

pytestmark = pytest.mark.process

POINTS = [{"x": x} for x in range(6)]
ROWS = [{"x": x, "square": x * x} for x in range(6)]


@pytest.mark.parametrize("workers", [1, 2])
def test_rows_are_those_of_the_points_in_their_order(tmp_path: Path, workers: int) -> None:
    assert run_points(tasks.square, POINTS, tmp_path, workers=workers) == ROWS
    shuffled = random.Random(0).sample(POINTS, len(POINTS))
    assert run_points(tasks.square, shuffled, tmp_path) == [ROWS[point["x"]] for point in shuffled]


def test_no_point_is_run_twice(tmp_path: Path) -> None:
    notes = tmp_path / "notes"
    points = [{"x": x, "notes": str(notes)} for x in (1, 2, 1, 3)]
    store = tmp_path / "deep" / "store"
    run_points(tasks.noted, points[:2], store, workers=1)
    rows = run_points(tasks.noted, points, store, workers=1)
    assert [row["square"] for row in rows] == [1, 4, 1, 9]
    assert [line.split()[0] for line in notes.read_text().splitlines()] == ["1", "2", "3"]


def test_progress_starts_with_what_is_there(tmp_path: Path) -> None:
    told: list[tuple[int, int]] = []
    run_points(tasks.square, POINTS[:2], tmp_path, workers=1)
    run_points(
        tasks.square, POINTS, tmp_path, workers=1, progress=lambda done, total: told.append((done, total))
    )
    assert told == [(done, 6) for done in range(2, 7)]


def test_other_tasks_versions_and_points_keep_their_rows(tmp_path: Path) -> None:
    run_points(tasks.square, POINTS, tmp_path, workers=1)
    run_points(tasks.noted, [{"x": 1, "notes": str(tmp_path / "notes")}], tmp_path, workers=1)
    version(tasks.square, 2)
    try:
        run_points(tasks.square, POINTS[:2], tmp_path, workers=1)
    finally:
        version(tasks.square, 1)
    with RowStore(tmp_path) as store:
        assert len(store.values()) == 6 + 1 + 2


@pytest.mark.parametrize("workers", [1, 2])
def test_a_failing_task_is_named_with_its_point(tmp_path: Path, workers: int) -> None:
    with pytest.raises(SweepError, match=r'\{"x": 3\}.*ValueError: no threes') as caught:
        run_points(tasks.failing_at_three, POINTS, tmp_path, workers=workers)
    assert "in failing_at_three" in "".join(caught.value.__notes__)
    with RowStore(tmp_path) as store:
        assert all(row["square"] == row["x"] ** 2 for row in store.values().values())
        assert workers > 1 or len(store.values()) == 3


def test_a_worker_that_dies_is_told(tmp_path: Path) -> None:
    with pytest.raises(beltsort.BeltsortError, match=r"\bworker\b.*\b2\b.*memory.*__main__"):
        run_points(tasks.dying_at_three, POINTS, tmp_path, workers=2)
    assert run_points(tasks.dying_at_three, POINTS[:3], tmp_path, workers=2) == ROWS[:3]


def test_results_are_plain_and_hide_no_point(tmp_path: Path) -> None:
    with pytest.raises(SweepError, match=r'\{"x": 0\}.*\bJSON\b'):
        run_points(tasks.not_finite, POINTS[:1], tmp_path)
    with pytest.raises(SweepError, match=r'\{"x": 0\}.*\bresult\b.*\bx\b'):
        run_points(tasks.clashing, POINTS[:1], tmp_path)


def test_another_version_of_beltsort_makes_no_row() -> None:
    assert "0.0.0" in attempt(tasks.square, "0.0.0", POINTS[0]).failure


def test_what_no_process_could_import_or_read_is_refused(tmp_path: Path) -> None:
    with pytest.raises(beltsort.ArgumentError, match=r"\btask\b.*<lambda>.*\bfunction\b"):
        run_points(lambda point: point, POINTS, tmp_path)
    with pytest.raises(beltsort.ArgumentError, match=r"\bpoint\b.*\bJSON\b.*\bNaN\b"):
        run_points(tasks.square, [{"x": float("inf")}], tmp_path)
    with pytest.raises(beltsort.ArgumentError, match=r"\bworkers\b.*\b0\b.*\b1\b"):
        run_points(tasks.square, POINTS, tmp_path, workers=0)


def test_a_store_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(SweepError, match=r"/file\b.*File exists"):
        run_points(tasks.square, POINTS, tmp_path / "file")


class Backwards:
    """A scheduler whose points finish in the reverse order."""

    def attempts(self, trial: engine.Trial, points: engine.Points) -> engine.Attempts:
        for number in reversed(range(len(points))):
            yield number, trial(points[number])


def test_the_order_of_finishing_does_not_matter(tmp_path: Path) -> None:
    assert run_points(tasks.square, POINTS, tmp_path, scheduler=Backwards()) == ROWS


def test_no_points_give_no_rows(tmp_path: Path) -> None:
    assert run_points(tasks.square, [], tmp_path) == []
