"""The course of a run: its first entry, steps to the end, and how it ended."""

from collections.abc import Callable
from typing import Protocol

from beltsort.cell import Cell, DivertingCell, EmergencyStopError
from beltsort.cell.stopping import stopping
from beltsort.errors import CellError
from beltsort.sorting.entries import AnyContent, Ended, State, StateChanged
from beltsort.sorting.holds import HeldError
from beltsort.sorting.journal import Entry
from beltsort.sorting.requests import Request


class Steps(Protocol):
    """The steps of a run."""

    @property
    def done(self) -> bool:
        """Whether all objects have left the belt."""

    def check(self) -> None:
        """Raise an exception if the process is to end."""

    def heed(self) -> Request | None:
        """Heed requests of a person; return one to stop."""

    def step(self) -> None:
        """Take the next step."""


def sort_to_end(
    record: Callable[[AnyContent], Entry],
    first: AnyContent,
    cell: Cell | DivertingCell,
    steps: Steps,
    begin: Callable[[], None] = lambda: None,
) -> Request | None:
    """Write the first entry, take steps until all objects have left the belt, and journal how it ended.

    A request to stop ends the run between two steps. If a failure does, every device is stopped.

    Parameters
    ----------
    record
        Writes an entry and applies it to the run's state.
    first
        The first entry.
    cell
        Its devices are stopped after a failure.
    steps
        The steps.
    begin
        Called before the first one.

    Returns
    -------
    Request or None
        The request by which the run was stopped.
    """
    stop: Request | None = None
    try:
        with stopping(cell):
            record(first)
            record(StateChanged(State.EXECUTE, first.kind))
            begin()
            while not steps.done:
                steps.check()
                if stop := steps.heed():
                    break
                steps.step()
    except BaseException as failure:
        ways = [*failure.hold.ways] if isinstance(failure, HeldError) else None
        record(StateChanged(_state_after(failure), repr(failure), ways=ways))
        record(Ended(repr(failure)))
        raise
    if stop is None:
        record(StateChanged(State.COMPLETE, "all objects have left the belt"))
        record(Ended("done"))
    else:
        record(StateChanged(State.STOPPED, f"{stop.by} asked to stop"))
        record(Ended("stopped"))
    return stop


def _state_after(failure: BaseException) -> State:
    """Return the state of a run after a failure: held if it can be resumed once the cell is in order."""
    match failure:
        case EmergencyStopError():
            return State.ABORTED
        case CellError():
            return State.HELD
        case KeyboardInterrupt():
            return State.STOPPED
        case _:
            return State.ABORTED
