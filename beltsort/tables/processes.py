"""Work shared among processes."""

import os
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context, parent_process
from threading import Thread
from typing import TypeVar

import beltsort
from beltsort.machine import processors

Progress = Callable[[int, int], None]
Work = TypeVar("Work")
Result = TypeVar("Result")


def at_least_one(name: str, number: int) -> int:
    """Return `number`, or raise an `ArgumentError` about `name` if it is below 1."""
    if number < 1:
        raise beltsort.ArgumentError(f"{name} is {number}, expected at least 1; give a positive number")
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
    workers = processors() if workers is None else at_least_one("workers", workers)
    if workers == 1:
        yield from _reported(map(task, work), len(work), progress)
        return
    pool = _pool(workers)
    try:
        yield from _reported(pool.map(task, work, chunksize=2), len(work), progress)
    except BrokenProcessPool:
        raise beltsort.BeltsortError(
            f"a worker process died, expected {workers} to live: if memory ran out, give fewer workers; "
            'a script must guard its main module by `if __name__ == "__main__":`'
        ) from None
    finally:
        pool.shutdown(cancel_futures=True)


def _pool(workers: int) -> ProcessPoolExecutor:
    """Return a pool of spawned processes: Open3D hangs in forked ones."""
    return ProcessPoolExecutor(workers, mp_context=get_context("spawn"), initializer=_follow_parent)


def _follow_parent() -> None:
    """Leave Ctrl-C to the parent process, but do not outlive it, however it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _reported(results: Iterator[Result], total: int, progress: Progress | None) -> Iterator[Result]:
    for done, result in enumerate(results, start=1):
        yield result
        if progress is not None:
            progress(done, total)
