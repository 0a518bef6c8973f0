"""Commands are told and not carried out."""

from collections.abc import Callable
from typing import Any

from beltsort.cell.commands import CommandError, Outcome
from beltsort.cell.wrappers.wrapped import ACTS, STOPS, Act, Call

Say = Callable[[str], None]


class DryRun:
    """Moves nothing: says what would be done, and reports it done.

    Health and scans are the device's own. As nothing moves, any scan is young enough: the time of every stop
    is 0.

    Parameters
    ----------
    say
        Called with each command in words.
    """

    def __init__(self, say: Say) -> None:
        self._say = say
        self._done: dict[str, tuple[str, float | None]] = {}

    def __call__(self, call: Call, act: Act) -> Any:
        """Pass the call on unless it would move something."""
        if call.name in ("stop", "position"):
            return None
        if call.name == "outcome_of":
            return Outcome.DONE if call.command_id in self._done else Outcome.NOT_DONE
        if call.name not in ACTS or call.command_id is None:
            return act(call)
        self._note(call.command_id, (call.name, call.target))
        return 0.0 if call.name in STOPS else None

    def _note(self, command_id: str, command: tuple[str, float | None]) -> None:
        """Say the command, once."""
        if command_id not in self._done:
            self._done[command_id] = command
            self._say(f"dry run: {command[0]}({command[1]}), {command_id}")
        if self._done[command_id] != command:
            raise CommandError(
                f"command id {command_id!r} was used for another command; give every command its own id",
                Outcome.NOT_DONE,
            )
