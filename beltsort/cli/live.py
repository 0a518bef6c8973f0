"""The display of a run: a live view on a terminal, otherwise a line for each event."""

from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from types import TracebackType
from typing import Self

from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.panel import Panel
from rich.table import Table
from rich.text import Text

from beltsort.cli.console import RunConsole
from beltsort.sorting.entries import Chosen, Decided, Planned, Resumed, Skipped, Started
from beltsort.sorting.entry_text import EntryFormatter
from beltsort.sorting.journal import Entry, Listener
from beltsort.sorting.report import REJECTED
from beltsort.util.text import position_number

BAR, SHORTEST_BAR = 20, 5  # characters of a bar for probability 1
LONGEST_NAME = 16  # characters of a class's name
GAP = 2  # characters between two positions
NUMBER = 5 + GAP  # characters of a probability after its bar
RECENT = 8  # number of recent events shown, if there is room


@contextmanager
def run_display(console: RunConsole) -> Iterator[Listener]:
    """Yield a listener of the journal that displays the run.

    Once the console is closed, the listener raises an `OSError`, which the journal records.
    """
    if console.is_terminal:
        with LiveView(console) as view:
            yield view
        return
    yield run_lines(console)


def run_lines(console: RunConsole) -> Listener:
    """Return a listener of the journal that prints a line for each event.

    Once the console is closed, the listener raises an `OSError`, which the journal records.
    """
    formatter = EntryFormatter()

    def listen(entry: Entry) -> None:
        if line := formatter.format(entry):
            console.print(line)
        if console.closed:
            raise OSError("the reader of the output has closed the pipe")

    return listen


class LiveView:
    """A journal listener that shows the belt, the belief per position, and the chosen action.

    It fits the terminal: as many events, classes and positions are shown as there is room for, and no line
    is wrapped.
    """

    def __init__(self, console: Console) -> None:
        self._formatter = EntryFormatter()
        self._console = console
        self._live = Live(console=console, refresh_per_second=8)
        self._recent: list[str] = []
        self._sorted: Counter[str] = Counter()
        self._why = ""
        self._objects: int | None = None
        self._empty = 0

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
            case Started(objects=objects) | Resumed(objects=objects):
                self._objects = objects
            case Planned() | Chosen() as choice:
                self._why = f"{self._formatter.name(choice.action)}: {self._formatter.why(choice)}"
            case Decided(label):
                self._sorted[REJECTED if label is None else self._formatter.bins[label]] += 1
            case Skipped():
                self._empty += 1
        if line:
            self._recent = [*self._recent, line][-RECENT:]
        self._live.update(self.__rich__())

    def __rich__(self) -> RenderableType:
        """Return the display as it is now."""
        beliefs = self._beliefs()
        # Two lines of the frame, the belt, the choice, two empty lines, and the cursor's.
        room = self._console.height - beliefs.row_count - 7
        recent = self._recent[-room:] if room > 0 else []
        lines = [Text(self._why, style="bold"), *map(Text, recent)]
        for line in lines:
            line.no_wrap, line.overflow = True, "ellipsis"
        return Panel(Group(self._belt(), Text(), beliefs, Text(), *lines), title="beltsort")

    def _belt(self) -> Text:
        counts = ", ".join(f"{count} {name}" for name, count in self._sorted.most_common())
        of = "" if self._objects is None else f" of {self._objects}"
        done = f"sorted {self._sorted.total()}{of}, {self._empty} empty"
        text = Text(f"{done}: {counts}" if counts else done, style="green")
        text.no_wrap, text.overflow = True, "ellipsis"
        return text

    def _beliefs(self) -> Table:
        """Return a row for each class; if there are too many, the likeliest ones at the belt end."""
        belief, classes = self._formatter.belief, self._formatter.classes
        name = min(max(map(len, classes), default=0), LONGEST_NAME)
        room = self._console.width - 4 - name  # the frame's sides are two columns each
        columns = belief[: max(1, room // (NUMBER + SHORTEST_BAR))]
        width = min(BAR, room // max(1, len(columns)) - NUMBER)
        table = Table.grid(padding=(0, GAP, 0, 0))
        for _ in range(len(columns) + 1):
            table.add_column(no_wrap=True, overflow="ellipsis")
        table.add_row(
            "", *("belt end" if j == 0 else f"position {position_number(j)}" for j in range(len(columns)))
        )
        rows = max(1, self._console.height - 10)
        shown = sorted(range(len(classes)), key=lambda i: -belief[0][i])[:rows]
        for i in sorted(shown):
            label = Text(classes[i], no_wrap=True, overflow="ellipsis")
            label.truncate(name, overflow="ellipsis")
            table.add_row(label, *(_bar(row[i], max(0, width)) for row in columns))
        return table


def _bar(probability: float, width: int) -> Text:
    filled = round(width * probability)
    return Text(f"{'█' * filled}{'░' * (width - filled)} {probability:.2f}")
