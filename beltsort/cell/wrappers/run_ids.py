"""Commands of one run never pass for those of another."""

from dataclasses import replace
from typing import Any

from beltsort.cell.wrappers.wrapped import Act, Call


class RunIds:
    """Puts the run's name before command ids: unique in a run, they must be unique for a device.

    Otherwise a device would take the first move of the second run for a repetition of the first run's.

    Parameters
    ----------
    run
        The run's name; a run that is resumed keeps it.
    """

    def __init__(self, run: str) -> None:
        self._run = run

    def __call__(self, call: Call, act: Act) -> Any:
        """Pass the call on."""
        if call.command_id is None:
            return act(call)
        return act(replace(call, command_id=f"{self._run}/{call.command_id}"))
