"""The display of a run: a live view on a terminal, otherwise a line for each event."""

from collections.abc import Iterator
from contextlib import contextmanager
from types import TracebackType
from typing import Any, Self

from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.panel import Panel
from rich.table import Table
from rich.text import Text

from beltsort.cli.console import RunConsole
from beltsort.sorting.entries import Chosen, Decided, Planned, Skipped, Started
from beltsort.sorting.entry_text import EntryFormatter
from beltsort.sorting.journal import Entry, Listener

BAR = 20  # characters of a bar for probability 1
RECENT = 8  # number of recent events shown


@contextmanager
def run_display(console: RunConsole) -> Iterator[Listener]:
    """Yield a listener of the journal that displays the run.

    Once the console is closed, the listener raises an `OSError`, which the journal records.
    """
    if console.is_terminal:
        with LiveView(console) as view:
            yield view
        return
    formatter = EntryFormatter()

    def listen(entry: Entry) -> None:
        if line := formatter.format(entry):
            console.print(line)
        if console.closed:
            raise OSError("the reader of the output has closed the pipe")

    yield listen


class LiveView:
    """A journal listener that shows the belt, the belief per position, and the chosen action."""

    def __init__(self, console: Console) -> None:
        self._formatter = EntryFormatter()
        self._live = Live(console=console, refresh_per_second=8)
        self._recent: list[str] = []
        self._sorted: list[str] = []
        self._why = ""
        self._objects = 0

    def __enter__(self) -> Self:
        """Start the display."""
        self._live.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Stop updating; the last state stays on the terminal."""
        self._live.stop()

    def __call__(self, entry: Entry) -> None:
        """Update the display with an entry."""
        line = self._formatter.format(entry)
        match entry.content:
            case Started(objects=objects):
                self._objects = objects
            case Planned() | Chosen() as choice:
                self._why = f"{self._formatter.name(choice.action)}: {self._formatter.why(choice)}"
            case Decided(label) if label is not None:
                self._sorted.append(self._formatter.bins[label])
            case Decided() | Skipped():
                self._sorted.append("-")
        if line:
            self._recent = [*self._recent, line][-RECENT:]
        self._live.update(self._render())

    def _render(self) -> RenderableType:
        return Panel(
            Group(
                self._belt(),
                Text(),
                self._beliefs(),
                Text(),
                Text(self._why, style="bold"),
                *map(Text, self._recent),
            ),
            title="beltsort",
        )

    def _belt(self) -> Text:
        done = len(self._sorted)
        waiting = max(0, self._objects - done)
        text = Text("sorted  " + " ".join(name[:1] for name in self._sorted), style="green")
        visible = min(waiting, len(self._formatter.belief))
        return text.append("  <- " + "(o)" * visible + " o " * (waiting - visible), style="default")

    def _beliefs(self) -> Table:
        table = Table.grid(padding=(0, 3))
        for _ in self._formatter.belief:
            table.add_column()
        table.add_row(*(f"position {j + 1}" for j in range(len(self._formatter.belief))))
        for i, name in enumerate(self._formatter.classes):
            table.add_row(*(self._bar(name, row[i]) for row in self._formatter.belief))
        return table

    def _bar(self, name: str, probability: Any) -> Text:
        filled = round(BAR * probability)
        return Text(f"{name:<12} {'█' * filled}{'░' * (BAR - filled)} {probability:.2f}")
