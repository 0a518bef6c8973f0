"""Commands to a cell's devices, their outcomes and timeouts."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from concurrent.futures import Future, wait
from dataclasses import dataclass
from enum import Enum
from threading import Thread
from typing import ClassVar, TypeAlias, TypeVar

from beltsort.errors import CellError

Result = TypeVar("Result")

TIMEOUT = 30.0
"""Default timeout of a command, seconds."""


class _Commanded(ABC):
    """Base class of acts.

    Attributes
    ----------
    verb
        Name of the kind of act in journals, command ids and messages.
    """

    verb: ClassVar[str]

    @property
    @abstractmethod
    def target(self) -> int:
        """The number of the viewpoint, object or bin."""

    def __str__(self) -> str:
        """Return verb and target."""
        return f"{self.verb} {self.target}"


@dataclass(frozen=True)
class MoveTo(_Commanded):
    """Move the camera to a viewpoint."""

    verb = "move"
    viewpoint: int

    @property
    def target(self) -> int:
        """The viewpoint."""
        return self.viewpoint


@dataclass(frozen=True)
class AdvanceTo(_Commanded):
    """Advance the belt until an object is at its end."""

    verb = "advance"
    object: int

    @property
    def target(self) -> int:
        """The object's number."""
        return self.object


@dataclass(frozen=True)
class SortInto(_Commanded):
    """Put the object at the belt end into a bin.

    Examples
    --------
    >>> str(SortInto(2))
    'sort 2'
    """

    verb = "sort"
    bin: int

    @property
    def target(self) -> int:
        """The bin."""
        return self.bin


Act: TypeAlias = MoveTo | AdvanceTo | SortInto
"""The motions and sorts that can be commanded: a closed set."""


class Outcome(Enum):
    """The outcome of a command."""

    DONE = "done"
    """It was executed, once."""
    NOT_DONE = "not done"
    """It was not executed, and will not be unless it is sent again."""
    BROKEN_OFF = "broken off"
    """It was interrupted during execution. Under the same id it is never executed again."""
    RUNNING = "running"
    """It is being executed; sending it again under its id waits for its end."""
    UNKNOWN = "unknown"
    """It may have been executed, or may still be."""


class CommandError(CellError):
    """A command that was not done.

    Parameters
    ----------
    message
        Value, expectation and remedy.
    outcome
        Its outcome, from which follows whether it may be repeated.
    """

    def __init__(self, message: str, outcome: Outcome) -> None:
        super().__init__(message)
        self.outcome = outcome


class EmergencyStopError(CommandError):
    """The cell's emergency stop is pressed. Software reports it; only hardware enforces and releases it."""


def within(timeout: float, what: str, act: Callable[[], Result]) -> Result:
    """Return the result of a function, waiting no longer than a timeout.

    This is for libraries whose own timeouts are not reliable. The function runs in a separate thread, which
    is abandoned when the time is over; a later result or exception is dropped.

    Parameters
    ----------
    timeout
        Seconds, above 0.
    what
        Name of the action in the error.
    act
        The function, without arguments.

    Raises
    ------
    CommandError
        With the outcome `UNKNOWN` when the time is over.
    BaseException
        The exception that `act` raised in time.

    Examples
    --------
    >>> within(1.0, "adding", lambda: 1 + 1)
    2
    """
    future: Future[Result] = Future()

    def run() -> None:
        try:
            future.set_result(act())
        except BaseException as failure:  # any exception; it is raised in the caller's thread
            future.set_exception(failure)

    Thread(target=run, name=what, daemon=True).start()
    wait([future], timeout)
    if not future.done():
        raise CommandError(
            f"{what} did not end within {timeout:g} s; look at the device and ask it what became of it",
            Outcome.UNKNOWN,
        )
    return future.result()
