"""Carrying out commands: each once, whatever fails in between.

What became of a command that failed is asked of the device first. `STEPS` says what is then done; only what
no device can tell is left to a person, and what a person says is honoured. The belt's position is compared
with what it should be before every command and after every advance, so that nothing is dropped where it does
not belong. docs/recovery.md shows the same as tables.
"""

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
    State,
    StateChanged,
)
from beltsort.sorting.holds import (
    FURTHER,
    Answer,
    HeldError,
    Hold,
    Operator,
    at_the_end,
    belt_elsewhere,
    in_doubt,
)
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
"""By act and what the device says became of it.

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

    def issue(self, act: Act, *, arriving: bool = False) -> None:
        """Carry out a new command; nothing, if it is learnt that the belt has passed objects.

        Raises
        ------
        HeldError
            If it cannot be done, nobody can say what became of it, or the belt stands elsewhere than it
            should.
        EmergencyStopError
            If the emergency stop is pressed.
        """
        boot_id = self._ask(partial(self._ready, act))
        if self._belt_stands_at(self._expected()):
            number = self._progress.commands + 1
            command = Command(f"{self._progress.run}-{act.verb}-{number}", act, boot_id, arriving)
            self._carry_out(command, self._begin(command))

    def settle(self, command: Command) -> None:
        """Carry out a command that a run broke off in: learn what became of it, and do what is left.

        Raises
        ------
        HeldError, EmergencyStopError
            As `issue`.
        """
        why, known = "the run was broken off here", self._progress.known_outcome
        self._carry_out(command, self._inquire(command, why) if known is None else Failure(known, why))

    def _carry_out(self, command: Command, failure: Failure | None) -> None:
        """Do what `STEPS` says about a failure, and about every further one, until the command is done."""
        delays = list(self._rules.retry_delays)
        tries = len(delays) + 1
        while failure is not None:
            # A device that cannot be asked is asked again, after a while.
            step = None if failure.outcome is None else STEPS[type(command.act), failure.outcome]
            if step is Step.RECORD:
                self._record(CommandDone(command.id))
                return
            if step is Step.ASK:
                failure = self._ask_person(command, failure)
                continue
            self._wait(delays, f"it failed {tries} times, most recently: {failure}")
            match step:
                case Step.WAIT:
                    failure = self._send(command, sent_before=True)
                case Step.REPEAT:
                    # Until the device is ready somebody may see to the cell: the belt is asked again then.
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
        """Write down an attempt, then send it."""
        if isinstance(command.act, SortInto):
            into = bin_of(self._cell, command.act.bin)
            self._record(Intended(command, into.name, into.number))
        else:
            self._record(Intended(command))
        return self._send(command)

    def _send(self, command: Command, *, sent_before: bool = False) -> Failure | None:
        """Send an attempt, and write down how it ended; return why it failed, if so.

        A device that cannot be reached when it is sent once more does not know whether it acted before.
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
            return None  # it has passed the target, and a person said to go on
        self._record(CommandDone(command.id, stopped=stopped))
        return None

    def _inquire(self, command: Command, why: str) -> Failure:
        """Ask the device what became of a command that failed."""
        device = self._device(command.act)
        try:
            outcome = device.outcome_of(command.id, command.boot_id)
            restarted = device.health().boot_id != command.boot_id
        except CommandError as reason:
            return Failure(None, why, unasked=str(reason))
        # What a restarted device does not know of may have been done before the restart.
        unsure = restarted and outcome is Outcome.NOT_DONE
        return Failure(Outcome.UNKNOWN if unsure else outcome, why)

    def _ask_person(self, command: Command, failure: Failure) -> Failure:
        """Ask a person what became of a sort, and write the answer down."""
        into, broken_off = bin_of(self._cell, command.act.target), failure.outcome is Outcome.BROKEN_OFF
        hold = in_doubt(command, self._progress.index, into, broken_off, failure.why)
        answer = self._hold(hold)
        if answer not in hold.answers:
            raise HeldError(hold)
        outcome = Outcome.DONE if answer is Answer.DONE else Outcome.NOT_DONE
        self._record(Answered(command.id, outcome.value))
        return Failure(outcome, failure.why)

    def _expected(self) -> range:
        """Return the objects of which one is at the belt end; during an advance there are several."""
        index, pending = self._progress.index, self._progress.pending
        last = pending.act.target if pending is not None and isinstance(pending.act, AdvanceTo) else index
        return range(index, last + 1)

    def _belt_stands_at(self, expected: range) -> bool:
        """Hold the run while the belt says that it stands elsewhere than at one of the expected objects.

        Returns False if a person has said that it passed objects, from which the run goes on. During an
        advance the belt may stand between two objects. What cannot tell its position is believed.
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
        """Return the boot id of a device that takes commands; hold the run while it takes none."""
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
        """Ask a device, again after each delay while it cannot be reached; then hold the run."""
        delays = list(self._rules.retry_delays)
        while True:
            try:
                return question()
            except EmergencyStopError:
                raise
            except CommandError as failure:
                self._wait(delays, str(failure))

    def _wait(self, delays: list[float], reason: str) -> None:
        """Wait before the next try; when all delays are used up, hold the run and begin anew."""
        if delays:
            time.sleep(delays.pop(0))
        else:
            self._hold(Hold(self._progress.pending, reason))
            delays.extend(self._rules.retry_delays)

    def _hold(self, hold: Hold) -> Answer | None:
        """Ask a person, and write down that it was asked."""
        command_id = None if hold.command is None else hold.command.id
        self._record(StateChanged(State.HELD, hold.reason, command_id))
        answer = self._operator(replace(hold, object=self._progress.index))
        said = "mended" if answer is None else answer.value
        self._record(StateChanged(State.EXECUTE, f"a person said: {said}"))
        return answer
