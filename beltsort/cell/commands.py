"""Commands to a cell's devices: what they can be, what becomes of them, how long to wait for that."""

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
"""Seconds that a command may take if the caller says nothing."""


class _Commanded(ABC):
    """What all acts have in common.

    Attributes
    ----------
    verb
        Names the kind of act in journals, ids and texts.
    """

    verb: ClassVar[str]

    @property
    @abstractmethod
    def target(self) -> int:
        """The number that the device is to reach."""

    def __str__(self) -> str:
        """Return it in words."""
        return f"{self.verb} {self.target}"


@dataclass(frozen=True)
class MoveTo(_Commanded):
    """Bring the camera to a viewpoint."""

    verb = "move"
    viewpoint: int

    @property
    def target(self) -> int:
        """The viewpoint."""
        return self.viewpoint


@dataclass(frozen=True)
class AdvanceTo(_Commanded):
    """Bring an object to the belt end."""

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
"""What an actuator can be commanded to do: a closed set."""


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
