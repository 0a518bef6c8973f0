"""Work shared among processes."""

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
    """Yield the results in the order of the work, each as soon as those before it are there.

    Parameters
    ----------
    task
        What is done with each piece of work; it and its results are pickled on their way.
    work
        The pieces.
    workers
        Processes, at least 1; default one for each core that this process may use. With 1 the work is done in
        this process.
    progress
        Called with the number of pieces done and in all.

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
    """Yield the number of each piece of work and its result, as soon as it is done.

    A generator that is closed, by an error or Ctrl-C too, ends its processes at once.

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
    """Return how many processes are of use."""
    wanted = processors() if workers is None else at_least_one("workers", workers)
    return max(1, min(wanted, len(work)))


@contextmanager
def _pool(workers: int) -> Iterator[ProcessPoolExecutor]:
    """Yield a pool of spawned processes (Open3D hangs in forked ones), which any error ends at once."""
    leash, held = Pipe(duplex=False)
    pool = ProcessPoolExecutor(
        workers, mp_context=get_context("spawn"), initializer=_on_leash, initargs=(leash,)
    )
    try:
        yield pool
    except BrokenProcessPool:
        raise BeltsortError(
            f"a worker process died, expected {workers} to live: if memory ran out, give fewer workers; "
            'a script must guard its main module by `if __name__ == "__main__":`'
        ) from None
    except BaseException:
        held.close()
        raise
    finally:
        pool.shutdown(cancel_futures=True)
        leash.close()
        held.close()


def _on_leash(leash: Connection) -> None:
    """Leave Ctrl-C to the parent process, but do not outlive the other end of the leash, nor the parent."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    Thread(target=_end_with, args=(leash,), daemon=True).start()


def _end_with(leash: Connection) -> None:
    parent = parent_process()
    wait([leash] if parent is None else [leash, parent.sentinel])
    os._exit(1)


def _reported(results: Iterator[Result], total: int, progress: Progress | None) -> Iterator[Result]:
    for done, result in enumerate(results, start=1):
        yield result
        if progress is not None:
            progress(done, total)
