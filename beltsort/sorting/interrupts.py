"""Signals that end a run in good order."""

import signal
from collections.abc import Callable
from types import FrameType, TracebackType
from typing import Any, Self, TypeAlias

from beltsort.errors import CellError, JournalError

Handler: TypeAlias = Callable[[int, FrameType | None], Any] | int | signal.Handlers
"""Of a signal, as `signal.getsignal` returns it."""

SIGNALS = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))


class Interrupted(KeyboardInterrupt):
    """The process was told to end.

    Attributes
    ----------
    signal
        By which.
    """

    def __init__(self, number: signal.Signals) -> None:
        self.signal = number
        super().__init__(number.name)


class Interrupts:
    """While open, the first signal of `SIGNALS` raises `Interrupted` once, and sets a flag for `check`.

    An exception that a handler raises inside a callback of some library may be swallowed there; the flag is
    not. Further signals only set it again, so that devices can be stopped in peace. A signal that is ignored
    (as SIGHUP under nohup) stays so. To be opened in the main thread.

    Parameters
    ----------
    at_once
        Whether the first signal raises. If not, it only sets the flag, for work that then ends in good order,
        and the second one raises.

    Examples
    --------
    >>> with Interrupts() as interrupts:
    ...     interrupts.check()
    """

    def __init__(self, *, at_once: bool = True) -> None:
        self._at_once = at_once
        self._received: signal.Signals | None = None
        self._before: dict[signal.Signals, Handler] = {}

    @property
    def received(self) -> bool:
        """Whether a signal has come."""
        return self._received is not None

    def check(self) -> None:
        """Raise `Interrupted` if a signal has come."""
        if self._received is not None:
            raise Interrupted(self._received)

    def __enter__(self) -> Self:
        """Handle the signals."""
        for number in SIGNALS:
            before = signal.getsignal(number)
            if before is not None and before is not signal.SIG_IGN:  # None: not installed from Python
                self._before[number] = before
                signal.signal(number, self._handle)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Restore the handlers; raise `Interrupted` if a library has turned the interrupt into another error.

        Errors of the cell and the journal are kept, since they must be reported.
        """
        for number, before in self._before.items():
            signal.signal(number, before)
        explained = isinstance(error, CellError | JournalError)
        if self._received is not None and isinstance(error, Exception) and not explained:
            raise Interrupted(self._received) from error

    def _handle(self, number: int, _frame: FrameType | None) -> None:
        first, self._received = self._received is None, signal.Signals(number)
        if first == self._at_once:
            self.check()
