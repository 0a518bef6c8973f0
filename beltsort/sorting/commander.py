"""Execution of commands, each exactly once in spite of failures.

After a failure, the device is first asked for the outcome of the command; `STEPS` defines what follows. An
operator is asked only if the device does not know. The position of the belt is compared with the expected one
before every command and after every advance, so that no object is sorted in place of another. The tables of
docs/recovery.md show the same.
"""

import logging
import time
from collections.abc import Callable
from dataclasses import replace
from enum import Enum
from functools import partial
from typing import NamedTuple, TypeVar, assert_never

from beltsort.cell import Actuator, Cell, CommandError, EmergencyStopError, Outcome
from beltsort.cell.bins import bin_of
from beltsort.cell.commands import Act, AdvanceTo, MoveTo, SortInto
from beltsort.cell.protocols import NOWHERE, TellsPosition
from beltsort.sorting.command import Command
from beltsort.sorting.entries import (
    Answered,
    CommandDone,
    CommandFailed,
    Intended,
    ObjectsPassed,
    Settled,
    State,
    StateChanged,
)
from beltsort.sorting.holds import (
    FURTHER,
    Answer,
    HeldError,
    Hold,
    Operator,
    Reply,
    at_the_end,
    belt_elsewhere,
    in_doubt,
)
from beltsort.sorting.progress import Progress
from beltsort.sorting.record import Record
from beltsort.sorting.rules import Rules

log = logging.getLogger(__name__)

Result = TypeVar("Result")


class Step(Enum):
    """The reaction to a command that failed."""

    RECORD = "recorded as done"
    WAIT = "sent again under its id, under which it never acts twice, to wait for its end"
    REPEAT = "sent again under a new id"
    ASK = "a person is asked whether it was done"


STEPS: dict[tuple[type[Act], Outcome], Step] = {
    (MoveTo, Outcome.DONE): Step.WAIT,
    (MoveTo, Outcome.RUNNING): Step.WAIT,
    (MoveTo, Outcome.NOT_DONE): Step.REPEAT,
    (MoveTo, Outcome.BROKEN_OFF): Step.REPEAT,
    (MoveTo, Outcome.UNKNOWN): Step.REPEAT,
    (AdvanceTo, Outcome.DONE): Step.WAIT,
    (AdvanceTo, Outcome.RUNNING): Step.WAIT,
    (AdvanceTo, Outcome.NOT_DONE): Step.REPEAT,
    (AdvanceTo, Outcome.BROKEN_OFF): Step.REPEAT,
    (AdvanceTo, Outcome.UNKNOWN): Step.REPEAT,
    (SortInto, Outcome.DONE): Step.RECORD,
    (SortInto, Outcome.RUNNING): Step.WAIT,
    (SortInto, Outcome.NOT_DONE): Step.REPEAT,
    (SortInto, Outcome.BROKEN_OFF): Step.ASK,
    (SortInto, Outcome.UNKNOWN): Step.ASK,
}
"""The reaction by act and outcome.

The targets of moves and advances are absolute, so they may be repeated after any outcome: a device that is
already there replies at once, with the time at which it stopped. A sort may not be repeated.
"""


class Failure(NamedTuple):
    """The outcome of a failed command (None if the device cannot be asked, and why), and why it failed."""

    outcome: Outcome | None
    why: str
    unasked: str = ""

    def __str__(self) -> str:
        """Return the reasons."""
        return f"{self.why}; then: {self.unasked}" if self.unasked else self.why


class Commander:
    """Executes the commands of a run.

    Parameters
    ----------
    cell
        The cell; its arm, belt and sorter execute the commands.
    progress
        State of the run.
    record
        Writes an entry and applies it to `progress`.
    rules
        Limits.
    operator
        Asked when a run is held.
    check
        Called before each attempt at a command or question that follows a failure.
    """

    def __init__(
        self,
        cell: Cell,
        progress: Progress,
        record: Record,
        rules: Rules,
        operator: Operator,
        check: Callable[[], None] = lambda: None,
    ) -> None:
        self._cell, self._progress, self._record = cell, progress, record
        self._rules, self._operator, self._check = rules, operator, check

    def issue(self, act: Act, *, arriving: bool = False) -> None:
        """Execute a new command, unless the operator says that objects have passed the belt end.

        Raises
        ------
        HeldError
            If the command cannot be done, its outcome cannot be established, or the belt is not at an
            expected position.
        EmergencyStopError
            If the emergency stop is pressed.
        """
        boot_id = self._ask(partial(self._ready, act))
        if self._belt_stands_at(self._expected()):
            number = self._progress.commands + 1
            command = Command(f"{self._progress.run}-{act.verb}-{number}", act, boot_id, arriving)
            self._carry_out(command, self._begin(command))

    def settle(self, command: Command) -> None:
        """Complete a command during which a run was interrupted, after establishing its outcome.

        Raises
        ------
        HeldError, EmergencyStopError
            As `issue`.
        """
        why, known = "the run was broken off here", self._progress.known_outcome
        self._carry_out(command, self._inquire(command, why) if known is None else Failure(known, why))

    def _carry_out(self, command: Command, failure: Failure | None) -> None:
        """React to a failure, and every further one, as `STEPS` defines, until the command is done."""
        delays = list(self._rules.retry_delays)
        tries = len(delays) + 1
        while failure is not None:
            # A device that cannot be reached is asked again after a delay.
            step = None if failure.outcome is None else STEPS[type(command.act), failure.outcome]
            if step is Step.RECORD:
                self._record(CommandDone(command.id))
                return
            if step is Step.ASK:
                failure = self._ask_operator(command, failure)
                continue
            self._wait(delays, f"it failed {tries} times, most recently: {failure}")
            match step:
                case Step.WAIT:
                    failure = self._send(command, sent_before=True)
                case Step.REPEAT:
                    # An operator may work at the cell until the device is ready: check the belt again then.
                    if not self._belt_stands_at(self._expected()):
                        return
                    boot_id = self._ask(partial(self._ready, command.act))
                    if not self._belt_stands_at(self._expected()):
                        return
                    command = command.again(boot_id)
                    failure = self._begin(command)
                case None:
                    failure = self._inquire(command, failure.why)

    def _begin(self, command: Command) -> Failure | None:
        """Journal an attempt, then send it."""
        if isinstance(command.act, SortInto):
            into = bin_of(self._cell, command.act.bin)
            self._record(Intended(command, into.name, into.number))
        else:
            self._record(Intended(command))
        return self._send(command)

    def _send(self, command: Command, *, sent_before: bool = False) -> Failure | None:
        """Send an attempt and journal its outcome; return the failure if there was one.

        If an attempt is sent again and the device cannot be reached, the first transmission may have acted.
        """
        act, stopped = command.act, None
        try:
            match act:
                case MoveTo(viewpoint):
                    stopped = self._cell.arm.move_to(viewpoint, command.id)
                case AdvanceTo(index):
                    stopped = self._cell.belt.advance_to(index, command.id)
                case SortInto(label):
                    self._cell.sorter.sort(label, command.id)
                case _:
                    assert_never(act)
        except CommandError as error:
            never_acts = error.outcome is Outcome.NOT_DONE and not sent_before
            self._record(CommandFailed(command.id, error.outcome.value, repr(error), final=never_acts))
            if isinstance(error, EmergencyStopError):
                raise
            if never_acts or error.outcome is Outcome.BROKEN_OFF:
                return Failure(error.outcome, str(error))
            return self._inquire(command, str(error))
        except BaseException as interrupt:
            self._record(CommandFailed(command.id, Outcome.UNKNOWN.value, repr(interrupt)))
            raise
        if isinstance(act, AdvanceTo) and not self._belt_stands_at(range(act.object, act.object + 1)):
            return None  # the belt has passed the target, and the operator continues from there
        self._record(CommandDone(command.id, stopped=stopped))
        return None

    def _inquire(self, command: Command, why: str) -> Failure:
        """Ask the device for the outcome of a failed command."""
        device = self._device(command.act)
        try:
            outcome = device.outcome_of(command.id, command.boot_id)
            restarted = device.health().boot_id != command.boot_id
        except CommandError as reason:
            return Failure(None, why, unasked=str(reason))
        # A restarted device may have done, before its restart, a command that it does not know.
        unsure = restarted and outcome is Outcome.NOT_DONE
        return Failure(Outcome.UNKNOWN if unsure else outcome, why)

    def _ask_operator(self, command: Command, failure: Failure) -> Failure:
        """Ask the operator whether a sort was done, and journal the answer."""
        into, broken_off = bin_of(self._cell, command.act.target), failure.outcome is Outcome.BROKEN_OFF
        hold = in_doubt(command, self._progress.index, into, broken_off, failure.why)
        answer = self._hold(hold)
        if answer not in hold.answers:
            raise HeldError(hold)
        outcome = Outcome.DONE if answer is Answer.DONE else Outcome.NOT_DONE
        self._record(Answered(command.id, outcome.value))
        return Failure(outcome, failure.why)

    def _expected(self) -> range:
        """Return the objects that may be at the belt end: one, or several during an advance."""
        index, pending = self._progress.index, self._progress.pending
        last = pending.act.target if pending is not None and isinstance(pending.act, AdvanceTo) else index
        return range(index, last + 1)

    def _belt_stands_at(self, expected: range) -> bool:
        """Hold the run until the belt reports an expected object at its end.

        Returns False if the operator says that objects have passed; the run continues from there. During an
        advance the belt may be between two objects. A belt that does not report its position is not checked.
        """
        belt, pending = self._cell.belt, self._progress.pending
        advancing = pending is not None and isinstance(pending.act, AdvanceTo)
        while isinstance(belt, TellsPosition):
            position = self._ask(belt.position)
            if position is None or position in expected or (position == NOWHERE and advancing):
                return True
            needs_home = self._ask(belt.health).needs_home
            answer = self._hold(belt_elsewhere(position, expected, pending, needs_home))
            if answer is Answer.PASSED:
                self._record(ObjectsPassed(position))
                return False
        return True

    def _ready(self, act: Act) -> str:
        """Return the boot id of the device once it accepts commands; hold the run until then."""
        while True:
            health = self._device(act).health()
            if health.emergency_stop:
                raise EmergencyStopError(
                    f"the emergency stop is pressed ({health.fault}); release it at the cell, then resume",
                    Outcome.NOT_DONE,
                )
            if health.ready:
                return health.boot_id
            hold = Hold(self._progress.pending, f"the device for {act.verb} is not ready: {health.fault}")
            if health.needs_home:
                reason = f"{hold.reason}; look which object is at the belt end"
                hold = replace(
                    hold, reason=reason, ways=(*at_the_end(self._expected()), FURTHER), person=True
                )
            self._hold(hold)

    def _device(self, act: Act) -> Actuator:
        match act:
            case MoveTo():
                return self._cell.arm
            case AdvanceTo():
                return self._cell.belt
            case SortInto():
                return self._cell.sorter
            case _:
                assert_never(act)

    def _ask(self, question: Callable[[], Result]) -> Result:
        """Ask a device, with retries while it cannot be reached; then hold the run."""
        delays = list(self._rules.retry_delays)
        while True:
            try:
                return question()
            except EmergencyStopError:
                raise
            except CommandError as failure:
                self._wait(delays, str(failure))

    def _wait(self, delays: list[float], reason: str) -> None:
        """Wait before the next attempt; after the last delay, hold the run and start again."""
        if delays:
            delay = delays.pop(0)
            log.warning("again in %g s: %s", delay, reason)
            time.sleep(delay)
        else:
            self._hold(Hold(self._progress.pending, reason))
            delays.extend(self._rules.retry_delays)
        self._check()

    def _hold(self, hold: Hold) -> Answer | None:
        """Ask the operator, and journal question and answer."""
        command_id = None if hold.command is None else hold.command.id
        asked = self._record(StateChanged(State.HELD, hold.reason, command_id, [*hold.ways]))
        answer = self._operator(replace(hold, object=self._progress.index, question=asked.number))
        if isinstance(answer, Reply):
            self._record(Settled(answer.answer, answer.by, answer.at))
            answer = answer.answer
        said = "fixed" if answer is None else answer.value
        self._record(StateChanged(State.EXECUTE, f"the operator says: {said}"))
        return answer
