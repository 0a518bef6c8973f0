"""Progress of long tasks."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import monotonic
from typing import TYPE_CHECKING

from beltsort.cli.output import print_status

if TYPE_CHECKING:
    from rich.console import Console

    from beltsort.sim.prepare import StageProgress
    from beltsort.util.processes import Progress


def tenths(what: str, write: Callable[[str], object] = print_status) -> "Progress":
    """Return a callback that writes a line at every tenth of `what`, on standard error by default."""

    def report(done: int, total: int) -> None:
        if _completes_tenth(done, total):
            write(f"{what} {100 * done // total} %")

    return report


def with_eta(what: str) -> "Progress":
    """Return a callback that prints a line at every tenth of `what`, with the estimated time left.

    Its first call is taken as the number of items done before this task started.
    """
    began = monotonic()
    before: int | None = None

    def report(done: int, total: int) -> None:
        nonlocal before
        if before is None:
            before = done
            print_status(f"{what} {done} of {total} done before")
        elif _completes_tenth(done, total):
            left = (monotonic() - began) / (done - before) * (total - done)
            print_status(f"{what} {done} of {total}, {left:.0f} s left")

    return report


def _completes_tenth(done: int, total: int) -> bool:
    return done * 10 // total > (done - 1) * 10 // total


@contextmanager
def stage_progress(console: "Console") -> "Iterator[StageProgress]":
    """Yield a function that starts the progress of a named stage: a bar on a terminal, otherwise lines."""
    if not console.is_terminal:
        yield lambda name: tenths(name, console.print)
        return
    from rich import progress as rich_progress

    columns = (
        rich_progress.TextColumn("{task.description:<9}"),
        rich_progress.BarColumn(),
        rich_progress.TimeElapsedColumn(),
        rich_progress.TimeRemainingColumn(),
    )
    with rich_progress.Progress(*columns, console=console) as bars:

        def start(name: str) -> "Progress":
            task = bars.add_task(name, total=None)
            return lambda done, total: bars.update(task, completed=done, total=total)

        yield start


@contextmanager
def terminal_progress(what: str) -> "Iterator[Progress | None]":
    """Yield a callback that draws a bar on standard error, or None where that is no terminal."""
    if not sys.stderr.isatty():
        yield None
        return
    from beltsort.cli.console import RunConsole

    with stage_progress(RunConsole(stderr=True)) as stage:
        yield stage(what)
