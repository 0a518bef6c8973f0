"""Runs a task on many points, on processes or on a cluster, and keeps every row as soon as it is there."""

import json
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import Any, Protocol, TypeAlias

import beltsort
from beltsort.errors import SweepError
from beltsort.sweep.attempt import Attempt, Point, Row, Task, attempt
from beltsort.sweep.store import RowStore, digest
from beltsort.util.processes import Progress, as_they_finish

Points: TypeAlias = Sequence[Point]
Trial: TypeAlias = Callable[[Point], Attempt]
Attempts: TypeAlias = Generator[tuple[int, Attempt], None, None]


class Scheduler(Protocol):
    """Where points are run."""

    def attempts(self, trial: Trial, points: Points) -> Attempts:
        """Yield the number of each point and what came of it, as soon as it is there."""
        ...


def run_points(
    task: Callable[[Mapping[str, Any]], Mapping[str, Any]],
    points: Sequence[Mapping[str, Any]],
    store: Path,
    *,
    workers: int | None = None,
    progress: Progress | None = None,
    scheduler: Scheduler | None = None,
) -> list[dict[str, Any]]:
    """Run a task on every point that the store has no row of.

    A row is on the disk before it counts: Ctrl-C or a kill loses only what was under way. The same points
    give the same rows whatever the number of processes and the order in which they finish, provided that the
    task is a function of its point.

    Parameters
    ----------
    task
        A function of a module, since other processes import it: takes a point, returns plain data (JSON
        without NaN) under names that the point has not. A task whose results have changed says so by another
        `version(task, N)`; beltsort's own version counts as well.
    points
        Plain data. Equal points are run once.
    store
        A folder, made if it is missing. Rows of other points and tasks in it are kept.
    workers
        Spawned processes, at least 1; default one for each core that this process may use. With 1 the work is
        done in this process. A script calls this under `if __name__ == "__main__":`.
    progress
        Called with the number of rows there and of rows wanted: once at the start, then after each row.
    scheduler
        Runs the points instead of processes of this machine.

    Returns
    -------
    list
        A row for each point, in their order: the point's keys, then the result's.

    Raises
    ------
    SweepError
        If the task fails, with its point named (finished rows are kept), or the store cannot be written.
    ArgumentError
        If `workers` is below 1, the task is no function of a module, or a point is no plain data.
    BeltsortError
        If a worker process dies.
    """
    keys = _keys(task, points)
    with RowStore(store) as rows:
        known = rows.values()
        waiting = {key: point for key, point in zip(keys, points, strict=True) if key not in known}
        report = _counter(len(set(keys)), len(waiting), progress)
        where, names = scheduler or _Processes(workers), list(waiting)
        trial = partial(attempt, task, beltsort.__version__)
        with closing(where.attempts(trial, list(waiting.values()))) as attempts:
            for number, done in attempts:
                key = names[number]
                known[key] = _row_of(done, waiting[key])
                rows.append({key: known[key]})
                report()
    return [known[key] for key in keys]


def finished_rows(task: Task, points: Sequence[Point], store: Path) -> list[Row]:
    """Return the rows that the store has of these points, in their order.

    Raises
    ------
    SweepError, ArgumentError
        As `run_points`.
    """
    with RowStore(store) as rows:
        known = rows.values()
    return [known[key] for key in _keys(task, points) if key in known]


def version(task: Task, number: int) -> Task:
    """Mark a task whose results differ from those that it gave under another number (1 if never marked)."""
    vars(task)["version"] = number
    return task


class _Processes:
    def __init__(self, workers: int | None) -> None:
        self.workers = workers

    def attempts(self, trial: Trial, points: Points) -> Attempts:
        return as_they_finish(trial, points, self.workers)


def _keys(task: Task, points: Points) -> list[str]:
    """Name the rows by all that they depend on."""
    name = f"{getattr(task, '__module__', '')}.{getattr(task, '__qualname__', '<?>')}"
    if "<" in name:
        raise beltsort.ArgumentError(
            f"the task is {task!r}, expected a function of a module: other processes cannot import it; "
            "define it at the top level of a file"
        )
    depends_on = [name, vars(task).get("version", 1), beltsort.__version__]
    try:
        return [digest(depends_on, point) for point in points]
    except (TypeError, ValueError) as reason:
        raise beltsort.ArgumentError(
            f"a point is no plain data ({reason}), expected what JSON can hold, without NaN: give numbers, "
            "text, lists and dictionaries"
        ) from reason


def _row_of(done: Attempt, point: Point) -> Row:
    """Return the row, or raise what the point failed with."""
    if done.row is not None:
        return done.row
    error = SweepError(
        f"the point {json.dumps(dict(point))} failed: {done.failure}; finished rows are kept: correct it and "
        "run the same again"
    )
    error.add_note(done.trace)
    raise error


def _counter(total: int, waiting: int, progress: Progress | None) -> Callable[[], None]:
    """Report the rows that are there, and return what reports one more each time."""
    done = total - waiting - 1

    def report() -> None:
        nonlocal done
        done += 1
        if progress is not None:
            progress(done, total)

    report()
    return report
