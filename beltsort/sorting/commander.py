"""Carrying out commands: each once, whatever fails in between.

What became of a command that failed is asked of the device first. `STEPS` says what is then done; only what
no device can tell is left to a person, and what a person says is honoured. The belt's position is compared
with what it should be before every command and after every advance, so that nothing is dropped where it does
not belong. docs/recovery.md shows the same as tables.
"""

import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from enum import Enum
from typing import NamedTuple, TypeVar

from beltsort.cell import Actuator, Cell, CommandError, EmergencyStopError, Outcome
from beltsort.cell.protocols import NOWHERE, TellsPosition
from beltsort.sorting.command import Command
from beltsort.sorting.entries import (
    Answered,
    CommandDone,
    CommandFailed,
    Intended,
    ObjectsPassed,
    State,
    StateChanged,
)
from beltsort.sorting.holds import FURTHER, Answer, HeldError, Hold, Operator, astray, at_the_end, in_doubt
from beltsort.sorting.progress import Progress
from beltsort.sorting.record import Record
from beltsort.sorting.rules import Rules

Result = TypeVar("Result")


class Step(Enum):
    """What is done with a command that failed."""

    RECORD = "written down as done"
    WAIT = "sent again under its id, under which it never acts twice, to wait for its end"
    REPEAT = "sent again under a new id"
    ASK = "a person is asked whether it was done"


STEPS: dict[tuple[str, Outcome], Step] = {
    ("move", Outcome.DONE): Step.WAIT,
    ("move", Outcome.RUNNING): Step.WAIT,
    ("move", Outcome.NOT_DONE): Step.REPEAT,
    ("move", Outcome.BROKEN_OFF): Step.REPEAT,
    ("move", Outcome.UNKNOWN): Step.REPEAT,
    ("advance", Outcome.DONE): Step.WAIT,
    ("advance", Outcome.RUNNING): Step.WAIT,
    ("advance", Outcome.NOT_DONE): Step.REPEAT,
    ("advance", Outcome.BROKEN_OFF): Step.REPEAT,
    ("advance", Outcome.UNKNOWN): Step.REPEAT,
    ("sort", Outcome.DONE): Step.RECORD,
    ("sort", Outcome.RUNNING): Step.WAIT,
    ("sort", Outcome.NOT_DONE): Step.REPEAT,
    ("sort", Outcome.BROKEN_OFF): Step.ASK,
    ("sort", Outcome.UNKNOWN): Step.ASK,
}
"""By command and what the device says became of it.

A move or an advance may be repeated whatever became of it, as its target is absolute: a device that stands
there already answers at once, and says since when. A sort may not.
"""


class Failure(NamedTuple):
    """Why a command failed, what became of it (None: the device cannot be asked), and then why not."""

    outcome: Outcome | None
    why: str
    unasked: str = ""

    def __str__(self) -> str:
        """Return the reasons."""
        return f"{self.why}; then: {self.unasked}" if self.unasked else self.why


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
        """Carry out a new command; nothing, if it is learnt that the belt has passed objects.

        Raises
        ------
        HeldError
            If it cannot be done, what became of it cannot be told, or the belt stands elsewhere than it
            should.
        EmergencyStopError
            If the emergency stop is pressed.
        """
        index = self._progress.index
        boot_id = self._asked(lambda: self._ready(name), None)
        if not self._belt_stands(range(index, index + 1), None):
            return
        identity = f"{self._progress.run}-{name}-{self._progress.commands + 1}"
        command = Command(identity, name, target, boot_id, arriving)
        self._record(Intended(command))
        self._finish(command, self._send(command))

    def settle(self, command: Command) -> None:
        """Carry out a command that a run broke off in: learn what became of it, and do what is left.

        Raises
        ------
        HeldError, EmergencyStopError
            As `issue`.
        """
        why, told = "the run was broken off here", self._progress.told
        self._finish(command, Failure(told, why) if told is not None else self._failure(command, why))

    def _finish(self, command: Command, failure: Failure | None) -> None:
        """Do what `STEPS` says until the command is done."""
        delays = iter(self._rules.retry_delays)
        while failure is not None:
            step = None if failure.outcome is None else STEPS[command.name, failure.outcome]
            match step:
                case Step.RECORD:
                    self._record(CommandDone(command.id))
                    return
                case Step.ASK:
                    failure = self._told(command, failure)
                    continue
            delays = self._pause(delays, command, failure)
            match step:
                case Step.WAIT:
                    failure = self._send(command, before=failure)
                case Step.REPEAT:
                    again = self._again(command)
                    if again is None:
                        return
                    command, failure = again, self._send(again)
                case _:
                    failure = self._failure(command, failure.why)

    def _pause(self, delays: Iterator[float], command: Command, failure: Failure) -> Iterator[float]:
        """Wait before the next attempt, longer each time; when all have failed, hold the run."""
        delay = next(delays, None)
        if delay is not None:
            time.sleep(delay)
            return delays
        attempts = len(self._rules.retry_delays) + 1
        self._hold(Hold(command, f"it failed {attempts} times, most recently: {failure}"))
        return iter(self._rules.retry_delays)

    def _again(self, command: Command) -> Command | None:
        """Write down the next attempt at a command; None if the belt has passed objects meanwhile.

        The belt is asked once more when the device is ready: until then, somebody may have seen to the cell.
        """
        if not self._belt_stands(self._places(command), command):
            return None
        boot_id = self._asked(lambda: self._ready(command.name), command)
        if not self._belt_stands(self._places(command), command):
            return None
        following = command.again(boot_id)
        self._record(Intended(following))
        return following

    def _send(self, command: Command, before: Failure | None = None) -> Failure | None:
        """Send an attempt; return why it failed, if so.

        `before` tells of an attempt that was sent already. A device that then cannot be reached does not know
        better than it did.
        """
        try:
            stopped = self._act(command)
        except CommandError as failure:
            refused = failure.outcome is Outcome.NOT_DONE and before is None
            self._failed(command, failure, final=refused)
            if isinstance(failure, EmergencyStopError):
                raise
            sure = refused or failure.outcome is Outcome.BROKEN_OFF
            return Failure(failure.outcome, str(failure)) if sure else self._failure(command, str(failure))
        except BaseException as interrupt:
            self._failed(command, interrupt, final=False)
            raise
        if command.name == "advance" and not self._belt_stands(
            range(command.target, command.target + 1), command
        ):
            return None  # it has passed the target, and a person said to go on
        self._record(CommandDone(command.id, stopped=stopped))
        return None

    def _failed(self, command: Command, failure: BaseException, *, final: bool) -> None:
        """Write down how an attempt failed, and whether it is certain that it never acts."""
        outcome = failure.outcome if isinstance(failure, CommandError) else Outcome.UNKNOWN
        self._record(CommandFailed(command.id, outcome.value, repr(failure), final))

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

    def _failure(self, command: Command, why: str) -> Failure:
        """Ask the device what became of a command that failed."""
        device = self._device(command.name)
        try:
            outcome = device.outcome_of(command.id, command.boot_id)
            restarted = device.health().boot_id != command.boot_id
        except CommandError as reason:
            return Failure(None, why, unasked=str(reason))
        # What a restarted device does not know of may have been done before the restart.
        unsure = restarted and outcome is Outcome.NOT_DONE
        return Failure(Outcome.UNKNOWN if unsure else outcome, why)

    def _told(self, command: Command, failure: Failure) -> Failure:
        """Ask a person what became of a sort, and write the answer down."""
        hold = in_doubt(command, self._progress.index, failure.outcome is Outcome.BROKEN_OFF, failure.why)
        answer = self._hold(hold)
        if answer not in hold.answers:
            raise HeldError(hold)
        outcome = Outcome.DONE if answer is Answer.DONE else Outcome.NOT_DONE
        self._record(Answered(command.id, outcome.value))
        return Failure(outcome, failure.why)

    def _places(self, command: Command) -> range:
        """Return the objects at which the belt may stand while a command is not done."""
        index = self._progress.index
        return range(index, (command.target if command.name == "advance" else index) + 1)

    def _belt_stands(self, expected: range, command: Command | None) -> bool:
        """Hold the run while the belt says that it stands elsewhere than at one of the expected objects.

        Returns False if a person has said that it passed objects, from which the run goes on. During an
        advance the belt may stand between two objects. What cannot tell its position is believed.
        """
        belt = self._cell.belt
        on_its_way = command is not None and command.name == "advance"
        while isinstance(belt, TellsPosition):
            position = self._asked(belt.position, command)
            if position is None or position in expected or (position == NOWHERE and on_its_way):
                return True
            needs_home = self._asked(belt.health, command).needs_home
            answer = self._hold(astray(position, expected, command, needs_home))
            if answer is Answer.PASSED:
                self._record(ObjectsPassed(position))
                return False
        return True

    def _hold(self, hold: Hold) -> Answer | None:
        """Ask a person, and write down that it was asked."""
        command_id = None if hold.command is None else hold.command.id
        self._record(StateChanged(State.HELD, hold.reason, command_id))
        answer = self._operator(replace(hold, object=self._progress.index))
        said = "mended" if answer is None else answer.value
        self._record(StateChanged(State.EXECUTE, f"a person said: {said}"))
        return answer

    def _asked(self, ask: Callable[[], Result], command: Command | None) -> Result:
        """Ask a device, again after each delay while it cannot be reached; then hold the run."""
        delays = iter(self._rules.retry_delays)
        while True:
            try:
                return ask()
            except (EmergencyStopError, HeldError):
                raise
            except CommandError as failure:
                delay = next(delays, None)
                if delay is None:
                    self._hold(Hold(command, str(failure)))
                    delays = iter(self._rules.retry_delays)
                else:
                    time.sleep(delay)

    def _ready(self, name: str) -> str:
        """Return the boot id of a device that takes commands; hold the run while it takes none."""
        while True:
            health = self._device(name).health()
            if health.emergency_stop:
                raise EmergencyStopError(
                    f"the emergency stop is pressed ({health.fault}); release it at the cell, then resume",
                    Outcome.NOT_DONE,
                )
            if health.ready:
                return health.boot_id
            pending, index = self._progress.pending, self._progress.index
            reason = f"the device for {name} is not ready: {health.fault}"
            if health.needs_home:
                places = range(index, index + 1) if pending is None else self._places(pending)
                ways = (*at_the_end(places), FURTHER)
                self._hold(
                    Hold(pending, f"{reason}; look which object is at the belt end", ways, person=True)
                )
            else:
                self._hold(Hold(pending, reason))

    def _device(self, name: str) -> Actuator:
        devices: dict[str, Actuator] = {
            "move": self._cell.arm,
            "sort": self._cell.sorter,
            "advance": self._cell.belt,
        }
        return devices[name]
