"""A record of every call, with its time."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from beltsort.cell.wrappers.wrapped import Act, Call


@dataclass(frozen=True)
class Recorded:
    """A call that has ended.

    Attributes
    ----------
    device
        Whose: `arm`, `camera`, `belt` or `sorter`.
    call
        What was asked.
    began
        When, seconds since the epoch.
    seconds
        How long it took.
    error
        What it raised, in words; None if it ended well.
    """

    device: str
    call: Call
    began: float
    seconds: float
    error: str | None


class Recorder:
    """Tells of every call when it has ended.

    Parameters
    ----------
    device
        Whose calls these are.
    tell
        Called with each call; `list.append` for example.
    """

    def __init__(self, device: str, tell: Callable[[Recorded], None]) -> None:
        self._device, self._tell = device, tell

    def __call__(self, call: Call, act: Act) -> Any:
        """Pass the call on."""
        began, start = time.time(), time.perf_counter()
        error: str | None = None
        try:
            return act(call)
        except BaseException as failure:
            error = repr(failure)
            raise
        finally:
            self._tell(Recorded(self._device, call, began, time.perf_counter() - start, error))
