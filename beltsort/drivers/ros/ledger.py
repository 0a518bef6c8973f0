"""A record of commands, for devices that do not remember command ids."""

import logging
from collections.abc import Callable
from dataclasses import dataclass

from beltsort.cell.commands import CommandError, Outcome

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Command:
    """A command: its name, target and outcome, and the time at which motion stopped (seconds) if done."""

    name: str
    target: int
    outcome: Outcome
    stop: float = float("nan")


class Ledger:
    """The outcomes of the commands of one device, as observed by this process.

    Examples
    --------
    >>> ledger = Ledger()
    >>> ledger.once("move_to", 2, "move-1", lambda: 12.5)
    12.5
    >>> ledger.once("move_to", 2, "move-1", lambda: 99.0)
    12.5
    >>> ledger["move-1"].outcome
    <Outcome.DONE: 'done'>
    """

    def __init__(self) -> None:
        self._commands: dict[str, Command] = {}

    def __getitem__(self, command_id: str) -> Command:
        """Return a command; raises KeyError for an unknown id."""
        return self._commands[command_id]

    def __contains__(self, command_id: str) -> bool:
        """Return whether an id is known."""
        return command_id in self._commands

    def is_last(self, command_id: str) -> bool:
        """Return whether a command is the last one."""
        return next(reversed(self._commands), None) == command_id

    def once(self, name: str, target: int, command_id: str, act: Callable[[], float]) -> float:
        """Execute a command unless it is done; return the time at which motion stopped.

        Raises
        ------
        CommandError
            As raised by `act`, or `NOT_DONE` if the id belongs to another command.
        """
        earlier = self._commands.get(command_id, Command(name, target, Outcome.NOT_DONE))
        if earlier.outcome is not Outcome.NOT_DONE and (earlier.name, earlier.target) != (name, target):
            raise CommandError(
                f"command id {command_id!r} belongs to {earlier.name}({earlier.target}), expected the same "
                f"command again, got {name}({target}); give every command its own id",
                Outcome.NOT_DONE,
            )
        if earlier.outcome is Outcome.DONE:
            return earlier.stop
        self._commands.pop(command_id, None)
        self._commands[command_id] = Command(name, target, Outcome.UNKNOWN)
        try:
            stop = act()
        except CommandError as failure:
            self._commands[command_id] = Command(name, target, failure.outcome)
            if failure.outcome is Outcome.UNKNOWN:
                log.warning("the outcome of %s, %s(%d), is unknown: %s", command_id, name, target, failure)
            raise
        self._commands[command_id] = Command(name, target, Outcome.DONE, stop)
        return stop
