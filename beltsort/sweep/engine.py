"""Run a task on many points, in processes or on a cluster; each finished row is stored at once."""

import hashlib
import json
import traceback
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Protocol, TypeAlias

import beltsort
from beltsort.errors import SweepError
from beltsort.util.keyed_log import KeyedLog
from beltsort.util.processes import Progress, as_they_finish

FILE = "rows.sqlite"

Point: TypeAlias = Mapping[str, Any]
Row: TypeAlias = dict[str, Any]
Task: TypeAlias = Callable[[Mapping[str, Any]], Mapping[str, Any]]
Points: TypeAlias = Sequence[Point]


@dataclass(frozen=True)
class Attempt:
    """The result of running a task on a point.

    Attributes
    ----------
    row
        The point and its result, or None.
    failure, trace
        The error in one line, and its traceback; empty if there was none.
    """

    row: Row | None
    failure: str = ""
    trace: str = ""


Trial: TypeAlias = Callable[[Point], Attempt]
Attempts: TypeAlias = Generator[tuple[int, Attempt], None, None]


def attempt(task: Task, version: str, point: Point) -> Attempt:
    """Run a task on a point, if this process has the given version of beltsort.

    Any exception is returned as text, since exceptions of other packages may not survive pickling.
    """
    try:
        if beltsort.__version__ != version:
            raise ValueError(
                f"a worker has beltsort {beltsort.__version__}, expected {version}: install that"
            )
        result = dict(task(point))
        if taken := sorted(result.keys() & point.keys()):
            raise ValueError(f"the result names {', '.join(taken)}, which the point has: rename it")
        return Attempt(json.loads(json.dumps({**point, **result}, allow_nan=False)))
    except Exception as error:
        return Attempt(None, f"{type(error).__name__}: {error}", traceback.format_exc())


class RowStore(KeyedLog):
    """Finished rows on disk, by `digest` of what they depend on.

    Parameters
    ----------
    folder
        Made if it is missing; the rows are in its file `rows.sqlite`.

    Raises
    ------
    SweepError
        If it cannot be read or written.
    """

    table, contents = "points", "rows"
    maker, error = "a sweep", SweepError

    def __init__(self, folder: Path) -> None:
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as reason:
            raise SweepError(f"the folder {folder} cannot be made: {reason}; name another one") from reason
        super().__init__(folder / FILE)


class Scheduler(Protocol):
    """Where points are run."""

    def attempts(self, trial: Trial, points: Points) -> Attempts:
        """Yield the number and the result of each point, as soon as it is done."""
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

    A row is on disk before it is reported: Ctrl-C or a kill loses only points that were running. The same
    points give the same rows whatever the number of processes and the order in which they finish, provided
    that the task is a function of its point.

    Parameters
    ----------
    task
        A function of a module, since other processes import it: takes a point, returns plain data (JSON
        without NaN) under names that the point does not use. Mark a task whose results have changed with
        another `version(task, N)`; a new version of beltsort also makes rows anew.
    points
        Plain data. Equal points are run once.
    store
        A folder, made if it is missing. Rows of other points and tasks in it are kept.
    workers
        Spawned processes, at least 1; default one for each core that this process may use. With 1 the work is
        done in this process. A script calls this under `if __name__ == "__main__":`.
    progress
        Called with the number of finished rows and of all rows: once at the start, then after each row.
    scheduler
        Runs the points in place of processes of this machine.

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
    """Mark a task with a version number, 1 by default; rows of other numbers are not reused."""
    vars(task)["version"] = number
    return task


def digest(*parts: Any) -> str:
    """Return a hash of plain data, which does not depend on the order of keys.

    Raises
    ------
    TypeError, ValueError
        If it is no plain data: JSON without NaN and infinities.
    """
    return hashlib.sha256(json.dumps(parts, sort_keys=True, allow_nan=False).encode()).hexdigest()


class _Processes:
    def __init__(self, workers: int | None) -> None:
        self.workers = workers

    def attempts(self, trial: Trial, points: Points) -> Attempts:
        return as_they_finish(trial, points, self.workers)


def _keys(task: Task, points: Points) -> list[str]:
    """Return the key of each row: a hash of everything that it depends on."""
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
