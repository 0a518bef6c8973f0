"""Carrying out commands: each once, whatever fails in between.

| what happened | what is done |
|---|---|
| the command was not done | it is repeated under the same id, up to `Rules.command_attempts` times |
| its fate is unknown | the device is asked; a move or an advance, whose targets are absolute, is repeated |
| a sort's fate is unknown, and the device cannot tell | the run is held: a person must look |
| all attempts failed | the run is held |
| a scan tells that the camera stands elsewhere | it is sent there once more, under a new id (`observing`) |
| it tells so again | the run is held |
| the emergency stop is pressed | the run is aborted |
"""

from collections.abc import Callable
from dataclasses import asdict

from beltsort.cell import Actuator, Cell, CommandError, EmergencyStopError, Outcome
from beltsort.command import Command
from beltsort.errors import CellError
from beltsort.packml import State
from beltsort.progress import Progress
from beltsort.record import Record
from beltsort.rules import Rules


class HeldError(CellError):
    """The run is held: what became of a command must be told by a person.

    Attributes
    ----------
    command
        The command in question.
    """

    def __init__(self, command: Command, reason: str) -> None:
        self.command = command
        super().__init__(
            f"held at {command.id} ({command.name} {command.target}): {reason}. Look at the cell, then "
            "resume, and say whether it was done (--settle done) or not (--settle not-done)"
        )


Operator = Callable[[Command, str], Outcome]
"""Tells what became of a command, given the reason for asking; `DONE` or `NOT_DONE`."""


def nobody(command: Command, reason: str) -> Outcome:
    """Answer no question: the run ends as held."""
    raise HeldError(command, reason)


class Commander:
    """Carries out the commands of a run.

    Parameters
    ----------
    cell
        Arm, belt and sorter.
    progress
        Of the run.
    record
        Writes an entry and applies it to `progress`.
    rules
        Limits.
    operator
        Asked where nothing else helps.
    """

    def __init__(
        self,
        cell: Cell,
        progress: Progress,
        record: Record,
        rules: Rules,
        operator: Operator,
    ) -> None:
        self._cell, self._progress, self._record = cell, progress, record
        self._rules, self._operator = rules, operator

    def issue(self, name: str, target: int, *, arriving: bool = False) -> None:
        """Carry out a new command.

        Raises
        ------
        HeldError
            If it cannot be done, or what became of it cannot be told.
        EmergencyStopError
            If the emergency stop is pressed.
        CommandError
            If the device takes no commands: this one was not sent.
        """
        identity = f"{self._progress.run}-{name}-{self._progress.commands + 1}"
        command = Command(identity, name, target, self._boot_id(name), arriving)
        self._record("intent", command=asdict(command))
        self._carry_out(command, Outcome.NOT_DONE)

    def settle(self, command: Command) -> None:
        """Carry out a command that a run broke off in: learn what became of it, and do what is left.

        Raises
        ------
        HeldError, EmergencyStopError
            As `issue`.
        """
        self._carry_out(command, self._fate(command))

    def _boot_id(self, name: str) -> str:
        """Return the boot id of a device that takes commands."""
        health = self._device(name).health()
        if health.emergency_stop:
            raise EmergencyStopError(
                f"the emergency stop is pressed ({health.fault}); release it at the cell, then resume",
                Outcome.NOT_DONE,
            )
        if not health.ready:
            raise CommandError(
                f"the device for {name} is not ready: {health.fault}; mend that, then resume",
                Outcome.NOT_DONE,
            )
        return health.boot_id

    def _carry_out(self, command: Command, fate: Outcome) -> None:
        while not self._tried(command, fate):
            fate = self._told(command, f"it failed {self._rules.command_attempts} times")

    def _tried(self, command: Command, fate: Outcome) -> bool:
        """Send a command until it is done or all attempts are spent; return whether it is done."""
        for _ in range(self._rules.command_attempts):
            if fate is Outcome.UNKNOWN:
                fate = self._told(command, "the device cannot tell what became of it")
            if self._is_done(command, fate):
                return True
            fate = self._attempt(command)
        return self._is_done(command, fate)

    def _is_done(self, command: Command, fate: Outcome) -> bool:
        """Whether a command is done; that is written down if it was learnt otherwise than by its end.

        A move or an advance that is said to be done is sent once more: its answer tells when it stopped.
        """
        if self._progress.pending is None:
            return True
        if fate is Outcome.DONE and command.name == "sort":
            self._record("outcome", command_id=command.id, outcome="done", stopped=None)
            return True
        return False

    def _attempt(self, command: Command) -> Outcome:
        """Send the command; a device that has carried it out answers at once."""
        try:
            stopped = self._act(command)
        except EmergencyStopError as failure:
            self._failed(command, failure)
            raise
        except CommandError as failure:
            self._failed(command, failure)
            return Outcome.NOT_DONE if failure.outcome is Outcome.NOT_DONE else self._fate(command)
        except BaseException as interrupt:
            self._failed(command, interrupt)
            raise
        self._record("outcome", command_id=command.id, outcome="done", stopped=stopped)
        return Outcome.DONE

    def _failed(self, command: Command, failure: BaseException) -> None:
        outcome = failure.outcome if isinstance(failure, CommandError) else Outcome.UNKNOWN
        self._record("outcome", command_id=command.id, outcome=outcome.value, error=repr(failure))

    def _act(self, command: Command) -> float | None:
        cell, target, identity = self._cell, command.target, command.id
        match command.name:
            case "move":
                return cell.arm.move_to(target, identity)
            case "advance":
                return cell.belt.advance_to(target, identity)
            case _:
                cell.sorter.sort(target, identity)
                return None

    def _fate(self, command: Command) -> Outcome:
        """Ask the device. A move or an advance may be repeated anyhow: its target is absolute."""
        if command.name != "sort":
            return Outcome.NOT_DONE
        device = self._device(command.name)
        try:
            fate = device.outcome_of(command.id)
            restarted = device.health().boot_id != command.boot_id
        except CommandError:
            return Outcome.UNKNOWN
        # What a restarted device does not know of may have been done before the restart.
        return Outcome.UNKNOWN if restarted and fate is Outcome.NOT_DONE else fate

    def _told(self, command: Command, reason: str) -> Outcome:
        """Ask the operator, and write the answer down."""
        self._record("state", state=State.HELD, reason=reason, command_id=command.id)
        answer = self._operator(command, reason)
        self._record("state", state=State.EXECUTE, reason=f"told that {command.id} was {answer.value}")
        return answer

    def _device(self, name: str) -> Actuator:
        devices: dict[str, Actuator] = {
            "move": self._cell.arm,
            "sort": self._cell.sorter,
            "advance": self._cell.belt,
        }
        return devices[name]
