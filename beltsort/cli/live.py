"""The live view of a run on a terminal."""

from types import TracebackType
from typing import Any, Self

from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.panel import Panel
from rich.table import Table
from rich.text import Text

from beltsort.cli.narrate import Narrator
from beltsort.sorting.entries import Chosen, Decided, Planned, Skipped, Started
from beltsort.sorting.journal import Entry

BAR = 20  # characters of a certain belief
RECENT = 8  # lines of history shown


class LiveView:
    """Shows belt, belief per position, and the chosen action with its reason; a listener of the journal."""

    def __init__(self, console: Console) -> None:
        self._narrator = Narrator()
        self._live = Live(console=console, refresh_per_second=8)
        self._recent: list[str] = []
        self._sorted: list[str] = []
        self._why = ""
        self._objects = 0

    def __enter__(self) -> Self:
        """Take over the terminal."""
        self._live.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Leave the last picture standing."""
        self._live.stop()

    def __call__(self, entry: Entry) -> None:
        """Show one more entry."""
        line = self._narrator.line(entry)
        match entry.content:
            case Started(objects=objects):
                self._objects = objects
            case Planned() | Chosen() as choice:
                self._why = f"{self._narrator.name(choice.action)}: {self._narrator.why(choice)}"
            case Decided(label) if label is not None:
                self._sorted.append(self._narrator.classes[label])
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
        visible = min(waiting, len(self._narrator.belief))
        return text.append("  <- " + "(o)" * visible + " o " * (waiting - visible), style="default")

    def _beliefs(self) -> Table:
        table = Table.grid(padding=(0, 3))
        for _ in self._narrator.belief:
            table.add_column()
        table.add_row(*(f"position {j + 1}" for j in range(len(self._narrator.belief))))
        for i, name in enumerate(self._narrator.classes):
            table.add_row(*(self._bar(name, row[i]) for row in self._narrator.belief))
        return table

    def _bar(self, name: str, probability: Any) -> Text:
        filled = round(BAR * probability)
        return Text(f"{name:<12} {'█' * filled}{'░' * (BAR - filled)} {probability:.2f}")
