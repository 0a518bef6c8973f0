"""Every command gets the time that the cell file grants it."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from beltsort.cell.wrappers.wrapped import Act, Call


class Deadlines:
    """Gives commands their timeouts, whatever the caller says.

    Parameters
    ----------
    seconds
        By the command's name; other calls are left alone.
    """

    def __init__(self, seconds: Mapping[str, float]) -> None:
        self._seconds = seconds

    def __call__(self, call: Call, act: Act) -> Any:
        """Pass the call on."""
        return act(replace(call, timeout=self._seconds.get(call.name, call.timeout)))
