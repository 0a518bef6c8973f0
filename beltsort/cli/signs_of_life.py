"""What a run tells the service manager that started it."""

from collections import Counter
from collections.abc import Callable
from typing import TYPE_CHECKING

from beltsort import ArgumentError
from beltsort.sorting.entries import Decided, State, StateChanged
from beltsort.sorting.entry_text import in_words
from beltsort.sorting.journal import Entry
from beltsort.sorting.moving.entries import Diverting, MovingResumed, MovingStarted
from beltsort.util.notify import ServiceManager

if TYPE_CHECKING:
    from beltsort.cellfile.description import CellDescription


class SignsOfLife:
    """Tells the manager that the loop has begun and goes on, and what the run does.

    The signs are given by the loop, not by a thread beside it, so that a loop that hangs gives none.

    Parameters
    ----------
    manager
        The service manager.
    interrupted
        Raises if a signal has come.
    """

    def __init__(self, manager: ServiceManager, interrupted: Callable[[], None]) -> None:
        self._manager, self._interrupted = manager, interrupted
        self._sorted: Counter[str] = Counter()
        self._ready = self._moving = False

    def check(self) -> None:
        """Give a sign of life, unless the run is to end: called before each step, and while waiting."""
        self._interrupted()
        self._manager.tell(*([] if self._ready else ["READY=1"]), "WATCHDOG=1")
        self._ready = True

    def listen(self, entry: Entry) -> None:
        """Tell the manager what an entry changes."""
        match entry.content:
            case MovingStarted() | MovingResumed():
                self._moving = True
            case Decided(name=name) | Diverting(name=name):
                self._sorted[name or ""] += 1
                self._manager.tell(f"STATUS={self._status(entry)}")
            case StateChanged(State.EXECUTE):
                self._manager.tell(f"STATUS={self._status(entry)}")
            case StateChanged(state, reason):
                self._manager.tell(f"STATUS={state.lower()}: {' '.join(in_words(reason).split())}")

    def _status(self, entry: Entry) -> str:
        counts = ", ".join(f"{count} {name}" for name, count in self._sorted.most_common())
        where = "" if entry.object is None or self._moving else f"object {entry.object} at the belt end; "
        return f"{where}sorted since the start: {counts or 'none'}"


def check_watchdog(manager: ServiceManager, description: "CellDescription") -> None:
    """Check that the manager gives a run more time between two signs of life than its longest step takes.

    Raises
    ------
    ArgumentError
        If it does not.
    """
    from beltsort.cellfile.watchdog import longest_step

    needed = longest_step(description)
    if manager.watchdog is not None and manager.watchdog < needed:
        raise ArgumentError(
            f"WatchdogSec is {manager.watchdog:g} s, expected at least {needed:g}: with the timeouts of the "
            "cell file a step may take that long, and the service manager would kill a run that is well; "
            "`beltsort service` writes a unit that fits"
        )
