"""The controller's side of the protocol as a state machine: a template for a real controller.

It uses no network and no threads. Time comes from a clock that is passed in, and each call first ends the
command whose time has passed.
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


class AdvanceFault(Enum):
    """A fault that a test can inject into the next advance of the belt."""

    STUCK = "stuck"
    """The belt does not move."""
    OVERSHOT = "overshot"
    """The belt goes one object too far."""


@dataclass(frozen=True)
class Machine:
    """The machine that the controller drives.

    Attributes
    ----------
    bins
        Number of bins.
    capacity
        Number of objects that fit into a bin.
    advance_seconds
        Duration of an advance by one object.
    sort_seconds
        Duration of a sort.
    memory
        Number of commands kept in memory.
    """

    bins: int = 5
    capacity: int = 1000
    advance_seconds: float = 1.5
    sort_seconds: float = 3.0
    memory: int = MEMORY


@dataclass
class Record:
    """A command and its state.

    Attributes
    ----------
    begin, end
        Times at which it starts to move and at which it ends, seconds on the controller's clock.
    """

    verb: int
    target: int
    phase: Phase
    reason: Reason
    begin: float
    end: float


class Controller:
    """Executes requests.

    Parameters
    ----------
    machine
        The machine that it drives.
    boot
        Boot id, above 0; no earlier start may have had the same.
    clock
        A monotonic clock, seconds.

    Attributes
    ----------
    sequence
        Sequence of the last request that was answered.

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
        self._at = 0  # the last object that reached the belt end
        self._between = False
        self._sorted = False
        self._emergency_stop = False
        self._fault = Reason.NOT_HOMED
        self._advance_fault: AdvanceFault | None = None
        self._delay = 0.0
        self._bins = [0] * machine.bins

    def is_new(self, request: Request) -> bool:
        """Return whether a request must be executed: late and repeated ones must not."""
        return is_ahead(request.sequence, of=self.sequence)

    def answer(self, request: Request) -> Reply:
        """Execute a request, which must be new, and return the reply."""
        self._end_due()
        self.sequence = request.sequence
        record = self._act(request)
        return self._reply(request, record)

    def press(self) -> None:
        """Press the emergency stop, with which hardware ends every motion."""
        self._end_due()
        self._break_off(Reason.EMERGENCY_STOP)
        self._emergency_stop = True

    def release(self) -> None:
        """Release the emergency stop."""
        self._emergency_stop = False

    def fill(self) -> None:
        """Fill every bin."""
        self._bins = [self._machine.capacity] * self._machine.bins

    def empty(self) -> None:
        """Empty every bin."""
        self._bins = [0] * self._machine.bins

    def home(self, index: int) -> None:
        """Set the object at the belt end, as checked by an operator, and clear the faults."""
        self._at, self._between, self._sorted = index, False, False
        self._fault = Reason.NONE

    def inject(self, fault: AdvanceFault) -> None:
        """Inject a fault into the next advance."""
        self._advance_fault = fault

    def delay(self, seconds: float) -> None:
        """Delay the motion of the next command, seconds."""
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
        """Execute a command unless its key was executed before; only executed commands are remembered."""
        if request.key == 0:
            return self._ended(request, Phase.NOT_DONE, Reason.OTHER_COMMAND)
        earlier = self._memory.get(request.key)
        if earlier is not None and earlier.phase is not Phase.NOT_DONE:
            if (earlier.verb, earlier.target) == (request.verb, request.target):
                return earlier
            return self._ended(request, Phase.NOT_DONE, Reason.OTHER_COMMAND)
        rejection = self._rejection(request)
        if rejection is not Reason.NONE:
            return self._ended(request, Phase.NOT_DONE, rejection)
        begin, self._delay = self._clock() + self._delay, 0.0
        duration = self._machine.sort_seconds
        if request.verb == Verb.ADVANCE:
            duration = self._machine.advance_seconds * (request.target - self._at)
        self._running = Record(
            request.verb, request.target, Phase.RUNNING, Reason.NONE, begin, begin + duration
        )
        self._memory.pop(request.key, None)
        self._memory[request.key] = self._running
        if len(self._memory) > self._machine.memory:
            self._memory.popitem(last=False)
            self._forgotten += 1
        self._end_due()
        return self._memory[request.key]

    def _rejection(self, request: Request) -> Reason:
        """Return the first reason to reject a command, in the order of docs/fieldbus.md, or `NONE`."""
        conditions = {
            Reason.EMERGENCY_STOP: self._emergency_stop,
            self._fault: self._fault is not Reason.NONE,
            Reason.BUSY: self._running is not None,
        }
        if request.verb == Verb.SORT:
            exists = 0 <= request.target < len(self._bins)
            conditions |= {
                Reason.NO_SUCH_BIN: not exists,
                Reason.BETWEEN_OBJECTS: self._between,
                Reason.ALREADY_SORTED: self._sorted,
                Reason.BIN_FULL: exists and self._bins[request.target] >= self._machine.capacity,
            }
        else:
            conditions[Reason.BACKWARDS] = request.target < self._at + self._between
        return next((reason for reason, holds in conditions.items() if holds), Reason.NONE)

    def _end_due(self) -> None:
        """End the running command if its time has passed."""
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
        fault, self._advance_fault = self._advance_fault, None
        match fault:
            case None:
                record.phase = Phase.DONE
                self._reach(record.target)
            case AdvanceFault.STUCK:
                record.phase, record.reason = Phase.NOT_DONE, Reason.STUCK
            case AdvanceFault.OVERSHOT:
                record.phase, record.reason = Phase.BROKEN_OFF, Reason.OVERSHOT
                self._reach(record.target + 1)
        self._fault = record.reason

    def _reach(self, index: int) -> None:
        if index != self._at or self._between:
            self._at, self._between, self._sorted = index, False, False

    def _break_off(self, reason: Reason) -> None:
        """Interrupt the running command at its current position."""
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
        """Return a record of a request that takes no time."""
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
