"""Process pools."""

import os
import signal
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import Pipe, get_context, parent_process
from multiprocessing.connection import Connection, wait
from threading import Thread
from typing import TypeVar

from beltsort._core import ArgumentError, BeltsortError
from beltsort.util.machine import processors

Progress = Callable[[int, int], None]
Work = TypeVar("Work")
Result = TypeVar("Result")


def at_least_one(name: str, number: int) -> int:
    """Return `number`, or raise an `ArgumentError` about `name` if it is below 1."""
    if number < 1:
        raise ArgumentError(f"{name} is {number}, expected at least 1; give a positive number")
    return number


def in_processes(
    task: Callable[[Work], Result], work: Sequence[Work], workers: int | None, progress: Progress | None
) -> Iterator[Result]:
    """Yield the results of a task in the order of the work items, as they become available.

    Parameters
    ----------
    task
        Function of a work item; it, the items and the results must be picklable.
    work
        The work items.
    workers
        Number of processes, at least 1; default one for each core that this process may use. With 1 the work
        is done in this process.
    progress
        Called with the number of items done and the total number.

    Raises
    ------
    ArgumentError
        If `workers` is below 1.
    BeltsortError
        If a worker process dies.
    """
    workers = _number_of(workers, work)
    if workers == 1:
        yield from _reported(map(task, work), len(work), progress)
        return
    with _pool(workers) as pool:
        yield from _reported(pool.map(task, work, chunksize=2), len(work), progress)


def as_they_finish(
    task: Callable[[Work], Result], work: Sequence[Work], workers: int | None = None
) -> Generator[tuple[int, Result], None, None]:
    """Yield the index of each work item and its result, in the order of completion.

    Closing the generator terminates its processes at once, also on an error or Ctrl-C.

    Parameters
    ----------
    task, work, workers
        As in `in_processes`.

    Raises
    ------
    ArgumentError, BeltsortError
        As `in_processes`.
    """
    workers = _number_of(workers, work)
    if workers == 1:
        yield from enumerate(map(task, work))
        return
    with _pool(workers) as pool:
        numbers = {pool.submit(task, piece): number for number, piece in enumerate(work)}
        for future in as_completed(numbers):
            yield numbers[future], future.result()


def _number_of(workers: int | None, work: Sequence[Work]) -> int:
    """Return the number of processes, at most one for each work item."""
    wanted = processors() if workers is None else at_least_one("workers", workers)
    return max(1, min(wanted, len(work)))


@contextmanager
def _pool(workers: int) -> Iterator[ProcessPoolExecutor]:
    """Yield a pool of spawned processes (Open3D hangs in forked ones), terminated at once on any error.

    Workers exit when the other end of their pipe is closed, by this process or by its death.
    """
    watched, kept = Pipe(duplex=False)
    pool = ProcessPoolExecutor(
        workers, mp_context=get_context("spawn"), initializer=_initialize, initargs=(watched,)
    )
    try:
        yield pool
    except BrokenProcessPool:
        raise BeltsortError(
            f"a worker process died, expected {workers} to run: if memory ran out, give fewer workers; "
            'a script must guard its main module by `if __name__ == "__main__":`'
        ) from None
    except BaseException:
        kept.close()
        raise
    finally:
        pool.shutdown(cancel_futures=True)
        watched.close()
        kept.close()


def _initialize(watched: Connection) -> None:
    """Leave Ctrl-C to the parent process, and exit when the parent ends or closes its end of the pipe."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)

    def exit_with_parent() -> None:
        parent = parent_process()
        wait([watched] if parent is None else [watched, parent.sentinel])
        os._exit(1)

    Thread(target=exit_with_parent, daemon=True).start()


def _reported(results: Iterator[Result], total: int, progress: Progress | None) -> Iterator[Result]:
    for done, result in enumerate(results, start=1):
        yield result
        if progress is not None:
            progress(done, total)
