"""What shows work in progress: bars and a live view on a terminal, plain lines elsewhere."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from beltsort.sorting.journal import Entry, Listener

if TYPE_CHECKING:
    from rich.console import Console

    from beltsort.cli.console import LastingConsole
    from beltsort.sim.prepare import StageProgress
    from beltsort.util.processes import Progress


@contextmanager
def stages(console: "Console") -> "Iterator[StageProgress]":
    """Yield what starts a progress bar, or plain lines every tenth where there is no terminal."""
    if not console.is_terminal:
        yield lambda name: _plain_progress(console, name)
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


def _plain_progress(console: "Console", name: str) -> "Progress":
    def report(done: int, total: int) -> None:
        if done * 10 // total > (done - 1) * 10 // total:
            console.print(f"{name} {100 * done // total} %")

    return report


@contextmanager
def listening(console: "LastingConsole") -> Iterator[Listener]:
    """Yield what shows the run: a live view, or a line per event where there is no terminal."""
    if console.is_terminal:
        from beltsort.cli.live import LiveView

        with LiveView(console) as view:
            yield view
        return
    from beltsort.cli.narrate import Narrator

    narrator = Narrator()

    def listen(entry: Entry) -> None:
        if line := narrator.line(entry):
            console.print(line)
        if console.gone:
            raise OSError("whoever read the output has gone")  # which the journal notes

    yield listen
