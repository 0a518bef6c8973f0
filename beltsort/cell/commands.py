"""Commands to a cell's devices: what becomes of them, and how to wait for it no longer than a deadline."""

from collections.abc import Callable
from concurrent.futures import Future, wait
from enum import Enum
from threading import Thread
from typing import TypeVar

from beltsort.errors import CellError

Result = TypeVar("Result")

TIMEOUT = 30.0
"""Seconds that a command may take if the caller says nothing."""


class Outcome(Enum):
    """What became of a command."""

    DONE = "done"
    """It acted, once."""
    NOT_DONE = "not done"
    """It did not act, and will not unless it is sent again."""
    BROKEN_OFF = "broken off"
    """It began and did not end as it should: half done perhaps. Under its id it never acts again."""
    RUNNING = "running"
    """It acts now; sent again under its id, it is waited for."""
    UNKNOWN = "unknown"
    """It may have acted, or may still act."""


class CommandError(CellError):
    """A command that did not end as it should.

    Parameters
    ----------
    message
        Value, expectation, remedy.
    outcome
        What became of it: whether it is safe to repeat.
    """

    def __init__(self, message: str, outcome: Outcome) -> None:
        super().__init__(message)
        self.outcome = outcome


class EmergencyStopError(CommandError):
    """The cell's emergency stop is pressed. Software reports it; only hardware enforces and releases it."""


def within(timeout: float, what: str, act: Callable[[], Result]) -> Result:
    """Return what `act` returns, waiting no longer than a deadline.

    For drivers whose own timeouts cannot be trusted. `act` runs in a thread of its own, which is left behind
    when it is late; whatever it still returns or raises then is dropped.

    Parameters
    ----------
    timeout
        Seconds, above 0.
    what
        Names the act in the error.
    act
        Called without arguments.

    Raises
    ------
    CommandError
        With the outcome `UNKNOWN` when the time is over.
    BaseException
        What `act` raised in time.

    Examples
    --------
    >>> within(1.0, "adding", lambda: 1 + 1)
    2
    """
    future: Future[Result] = Future()

    def run() -> None:
        try:
            future.set_result(act())
        except BaseException as failure:  # whatever it is, it belongs to the caller
            future.set_exception(failure)

    Thread(target=run, name=what, daemon=True).start()
    wait([future], timeout)
    if not future.done():
        raise CommandError(
            f"{what} did not end within {timeout:g} s; look at the device and ask it what became of it",
            Outcome.UNKNOWN,
        )
    return future.result()
