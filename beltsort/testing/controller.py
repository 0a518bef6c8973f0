"""The controller's side as a plain state machine: the specification to program a real controller by.

It knows no network and no thread. Time comes from the clock it is given, and whatever ended since the last
call is noticed at the beginning of the next.
"""

from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

from beltsort.cell.protocols import NOWHERE
from beltsort.drivers.fieldbus.wire import (
    MEMORY,
    Phase,
    Reason,
    Reply,
    Request,
    Verb,
    is_ahead,
)


class Mishap(Enum):
    """What the next advance of the belt can be made to suffer, for tests."""

    STUCK = "stuck"
    """The belt does not move."""
    OVERSHOT = "overshot"
    """The belt goes one object too far."""


@dataclass(frozen=True)
class Machine:
    """What the controller drives.

    Attributes
    ----------
    bins
        Number of bins.
    capacity
        Objects that fit into a bin.
    advance_seconds
        Duration of an advance by one object.
    sort_seconds
        Duration of a sort.
    memory
        Commands that are remembered.
    """

    bins: int = 5
    capacity: int = 1000
    advance_seconds: float = 1.5
    sort_seconds: float = 3.0
    memory: int = MEMORY


@dataclass
class Record:
    """A command and what became of it.

    Attributes
    ----------
    end
        Time at which it ends or ended, seconds on the controller's clock.
    """

    verb: int
    target: int
    phase: Phase
    reason: Reason
    begin: float
    end: float


class Controller:
    """Carries out requests.

    Parameters
    ----------
    machine
        What it drives.
    boot
        A number that no earlier start had, above 0.
    clock
        Seconds that never go back.

    Attributes
    ----------
    sequence
        Of the last request that was answered.

    Examples
    --------
    >>> controller = Controller(Machine(), boot=1, clock=lambda: 0.0)
    >>> controller.answer(Request(1, Verb.SORT, target=2, key=77)).reason.name
    'NOT_HOMED'
    """

    def __init__(self, machine: Machine, boot: int, clock: Callable[[], float]) -> None:
        self._machine = machine
        self._boot = boot
        self._clock = clock
        self.sequence = 0
        self._memory: OrderedDict[int, Record] = OrderedDict()
        self._forgotten = 0
        self._running: Record | None = None
        self._at = 0  # the last object that has reached the belt end
        self._between = False
        self._sorted = False
        self._emergency_stop = False
        self._fault = Reason.NOT_HOMED
        self._mishap: Mishap | None = None
        self._delay = 0.0
        self._bins = [0] * machine.bins

    def is_new(self, request: Request) -> bool:
        """Tell whether a request is to be acted on: late ones, and those seen before, are not."""
        return is_ahead(request.sequence, of=self.sequence)

    def answer(self, request: Request) -> Reply:
        """Act on a request, which `is_new`, and reply."""
        self._settle()
        self.sequence = request.sequence
        record = self._act(request)
        return self._reply(request, record)

    def press(self) -> None:
        """Press the emergency stop: hardware has ended every motion."""
        self._settle()
        self._break_off(Reason.EMERGENCY_STOP)
        self._emergency_stop = True

    def release(self) -> None:
        """Release the emergency stop."""
        self._emergency_stop = False

    def fill(self) -> None:
        """Let every bin be full."""
        self._bins = [self._machine.capacity] * self._machine.bins

    def empty(self) -> None:
        """Empty every bin."""
        self._bins = [0] * self._machine.bins

    def home(self, index: int) -> None:
        """Take the word of somebody who has looked: object `index` is at the belt end."""
        self._at, self._between, self._sorted = index, False, False
        self._fault = Reason.NONE

    def suffer(self, mishap: Mishap) -> None:
        """Let the next advance go wrong."""
        self._mishap = mishap

    def delay(self, seconds: float) -> None:
        """Let the next command begin to move something so much later."""
        self._delay = seconds

    def _act(self, request: Request) -> Record:
        match request.verb:
            case Verb.ADVANCE | Verb.SORT:
                return self._command(request)
            case Verb.RECALL:
                return self._memory.get(request.key) or self._ended(request, Phase.FORGOTTEN)
            case Verb.LOOK:
                return self._ended(request, Phase.DONE)
            case Verb.STOP:
                self._break_off(Reason.STOPPED)
                return self._ended(request, Phase.DONE)
            case Verb.HOME:
                return self._home(request)
        return self._ended(request, Phase.NOT_DONE, Reason.NO_SUCH_VERB)

    def _command(self, request: Request) -> Record:
        """Carry out a command unless its id acted before; keep it in memory only if it acts."""
        if request.key == 0:
            return self._ended(request, Phase.NOT_DONE, Reason.OTHER_COMMAND)
        earlier = self._memory.get(request.key)
        if earlier is not None and earlier.phase is not Phase.NOT_DONE:
            if (earlier.verb, earlier.target) == (request.verb, request.target):
                return earlier
            return self._ended(request, Phase.NOT_DONE, Reason.OTHER_COMMAND)
        refusal = self._refusal(request)
        if refusal is not Reason.NONE:
            return self._ended(request, Phase.NOT_DONE, refusal)
        begin, self._delay = self._clock() + self._delay, 0.0
        end = begin + self._duration(request)
        self._running = Record(request.verb, request.target, Phase.RUNNING, Reason.NONE, begin, end)
        self._remember(request.key, self._running)
        self._settle()
        return self._memory[request.key]

    def _refusal(self, request: Request) -> Reason:
        refusals = {
            Reason.EMERGENCY_STOP: self._emergency_stop,
            self._fault: self._fault is not Reason.NONE,
            Reason.BUSY: self._running is not None,
            **(self._sort_refusals if request.verb == Verb.SORT else self._advance_refusals)(request.target),
        }
        return next((reason for reason, holds in refusals.items() if holds), Reason.NONE)

    def _advance_refusals(self, index: int) -> dict[Reason, bool]:
        return {Reason.BACKWARDS: index < self._at + self._between}

    def _sort_refusals(self, label: int) -> dict[Reason, bool]:
        exists = 0 <= label < len(self._bins)
        return {
            Reason.NO_SUCH_BIN: not exists,
            Reason.BETWEEN_OBJECTS: self._between,
            Reason.ALREADY_SORTED: self._sorted,
            Reason.BIN_FULL: exists and self._bins[label] >= self._machine.capacity,
        }

    def _duration(self, request: Request) -> float:
        if request.verb == Verb.SORT:
            return self._machine.sort_seconds
        return self._machine.advance_seconds * (request.target - self._at)

    def _remember(self, key: int, record: Record) -> None:
        self._memory.pop(key, None)
        self._memory[key] = record
        if len(self._memory) > self._machine.memory:
            self._memory.popitem(last=False)
            self._forgotten += 1

    def _settle(self) -> None:
        """End what has come to its end by now."""
        record = self._running
        if record is None or self._clock() < record.end:
            return
        self._running = None
        if record.verb == Verb.SORT:
            record.phase, self._sorted = Phase.DONE, True
            self._bins[record.target] += 1
        else:
            self._arrive(record)

    def _arrive(self, record: Record) -> None:
        mishap, self._mishap = self._mishap, None
        match mishap:
            case None:
                record.phase = Phase.DONE
                self._reach(record.target)
            case Mishap.STUCK:
                record.phase, record.reason = Phase.NOT_DONE, Reason.STUCK
            case Mishap.OVERSHOT:
                record.phase, record.reason = Phase.BROKEN_OFF, Reason.OVERSHOT
                self._reach(record.target + 1)
        self._fault = record.reason

    def _reach(self, index: int) -> None:
        if index != self._at or self._between:
            self._at, self._between, self._sorted = index, False, False

    def _break_off(self, reason: Reason) -> None:
        """End the running command where it is."""
        record, self._running = self._running, None
        if record is None:
            return
        record.phase, record.reason, record.end = Phase.BROKEN_OFF, reason, self._clock()
        if record.verb == Verb.ADVANCE:
            passed = max(0, int((record.end - record.begin) / self._machine.advance_seconds))
            self._at, self._between, self._sorted = self._at + passed, True, False

    def _home(self, request: Request) -> Record:
        if self._emergency_stop or self._running is not None:
            reason = Reason.EMERGENCY_STOP if self._emergency_stop else Reason.BUSY
            return self._ended(request, Phase.NOT_DONE, reason)
        self.home(request.target)
        return self._ended(request, Phase.DONE)

    def _ended(self, request: Request, phase: Phase, reason: Reason = Reason.NONE) -> Record:
        """Return a record of what takes no time."""
        now = self._clock()
        return Record(request.verb, request.target, phase, reason, now, now)

    def _reply(self, request: Request, record: Record) -> Reply:
        at_rest = self._running is None and not self._between and self._fault is not Reason.NOT_HOMED
        return Reply(
            sequence=request.sequence,
            verb=request.verb,
            key=request.key,
            phase=record.phase,
            reason=record.reason,
            age=max(0, round(1000 * (self._clock() - record.end))),
            boot=self._boot,
            position=self._at if at_rest else NOWHERE,
            remembered=len(self._memory),
            forgotten=self._forgotten,
            ready=self._fault is Reason.NONE and not self._emergency_stop,
            emergency_stop=self._emergency_stop,
            fault=self._fault,
            bins=tuple(self._bins),
        )
