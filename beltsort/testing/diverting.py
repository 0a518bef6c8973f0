"""The controller of a belt that never stops as a state machine: a template for a real controller.

It uses no network and no threads. Time comes from a clock that is passed in, and each call first carries out
the diversions whose objects have come by their diverters.
"""

from collections.abc import Callable
from dataclasses import dataclass

from beltsort.drivers.fieldbus.diversions import (
    QUEUE,
    DiversionPhase,
    DiversionReason,
    DiversionReply,
    DiversionRequest,
    DiversionVerb,
)
from beltsort.drivers.fieldbus.wire import MEMORY, is_ahead


@dataclass(frozen=True)
class DivertingMachine:
    """The belt and its diverters.

    Attributes
    ----------
    diverters
        Distance of each bin's diverter from the reference mark, micrometres along the belt.
    speed
        Speed of the belt, micrometres per second.
    lead
        Distance before the diverter at which it must have its order, micrometres.
    window
        Coordinates no further apart than this are of the same object, micrometres.
    capacity
        Number of objects that fit into a bin.
    queue, memory
        Number of queued diversions, and of ended ones that are remembered.
    """

    diverters: tuple[int, ...] = (1_000_000, 1_300_000, 1_600_000)
    speed: int = 200_000
    lead: int = 50_000
    window: int = 20_000
    capacity: int = 1000
    queue: int = QUEUE
    memory: int = MEMORY


@dataclass
class Diversion:
    """A diversion and its state."""

    key: int
    object: int
    coordinate: int
    bin: int
    phase: DiversionPhase
    reason: DiversionReason = DiversionReason.NONE


class DivertingController:
    """Queues and carries out diversions.

    Parameters
    ----------
    machine
        The machine that it drives.
    boot
        Boot id, above 0; no earlier start may have had the same.
    clock
        A monotonic clock, seconds.
    ended
        Called with each diversion that has ended, before any reply says so.

    Attributes
    ----------
    sequence
        Sequence of the last request that was answered.

    Examples
    --------
    >>> controller = DivertingController(DivertingMachine(), boot=1, clock=lambda: 0.0)
    >>> request = DiversionRequest(1, DiversionVerb.DIVERT, key=77, object=5, coordinate=0, bin=2, boot=1)
    >>> controller.answer(request).phase.name
    'QUEUED'
    """

    def __init__(
        self,
        machine: DivertingMachine,
        boot: int,
        clock: Callable[[], float],
        ended: Callable[[Diversion], None] = lambda _diversion: None,
    ) -> None:
        self._machine = machine
        self._boot = boot
        self._clock = clock
        self._ended = ended
        self.sequence = 0
        self._memory: dict[int, Diversion] = {}
        self._queue: list[Diversion] = []
        self._forgotten = 0
        self._bins = [0] * len(machine.diverters)
        self._emergency_stop = False
        self._moving = True
        self._position = 0
        self._now = clock()  # when the belt was at that position
        self._began = (0, self._now)  # position and time at which it last began to move

    def is_new(self, request: DiversionRequest) -> bool:
        """Return whether a request must be executed: late and repeated ones must not."""
        return is_ahead(request.sequence, of=self.sequence)

    def answer(self, request: DiversionRequest) -> DiversionReply:
        """Execute a request, which must be new, and return the reply."""
        self._move()
        self.sequence = request.sequence
        phase, reason = self._act(request)
        return DiversionReply(
            sequence=request.sequence,
            verb=request.verb,
            key=request.key,
            phase=phase,
            reason=reason,
            boot=self._boot,
            position=self._position,
            stamp=round(1e6 * self._now),
            moving=self._moving,
            emergency_stop=self._emergency_stop,
            queued=len(self._queue),
            forgotten=self._forgotten,
            bins=tuple(self._bins),
        )

    def look(self) -> DiversionReply:
        """Return the state as a reply to no request."""
        return self.answer(DiversionRequest(self.sequence, DiversionVerb.LOOK))

    def run(self) -> None:
        """Carry out what is due. To be called often; requests and buttons do so too."""
        self._move()

    def start(self) -> None:
        """Start the belt, as an operator does after a stop; nothing moves while the stop is pressed."""
        self._move()
        if not self._moving and not self._emergency_stop:
            self._moving, self._began = True, (self._position, self._now)

    def press(self, coasting: int = 0) -> None:
        """Press the emergency stop; the belt coasts, micrometres, and no diverter moves any more."""
        self._move()
        self._emergency_stop, self._moving = True, False
        self._position += coasting
        self._carry_out()

    def release(self) -> None:
        """Release the emergency stop; the belt stands until it is started."""
        self._emergency_stop = False

    def fill(self) -> None:
        """Fill every bin."""
        self._move()
        self._bins = [self._machine.capacity] * len(self._bins)

    def empty(self) -> None:
        """Empty every bin."""
        self._move()
        self._bins = [0] * len(self._bins)

    def _act(self, request: DiversionRequest) -> tuple[DiversionPhase, DiversionReason]:
        match request.verb:
            case DiversionVerb.LOOK:
                return DiversionPhase.DONE, DiversionReason.NONE
            case DiversionVerb.STOP:
                self._moving = False
                return DiversionPhase.DONE, DiversionReason.NONE
            case DiversionVerb.RECALL:
                known = self._memory.get(request.key)
                return (
                    (known.phase, known.reason) if known else (DiversionPhase.UNKNOWN, DiversionReason.NONE)
                )
            case DiversionVerb.DIVERT:
                return self._divert(request)
        return DiversionPhase.NOT_DONE, DiversionReason.NO_SUCH_VERB

    def _divert(self, request: DiversionRequest) -> tuple[DiversionPhase, DiversionReason]:
        """Queue a diversion unless its key is known; a refused one is not remembered."""
        order = (request.object, request.coordinate, request.bin)
        known = self._memory.get(request.key)
        if request.boot == self._boot and known is not None:
            if (known.object, known.coordinate, known.bin) == order:
                return known.phase, known.reason
            return DiversionPhase.NOT_DONE, DiversionReason.OTHER_COMMAND
        refusal = self._refusal(request)
        if refusal is not DiversionReason.NONE:
            return DiversionPhase.NOT_DONE, refusal
        late = self._position > request.coordinate + self._machine.diverters[request.bin] - self._machine.lead
        phase = DiversionPhase.TOO_LATE if late else DiversionPhase.QUEUED
        entry = self._memory[request.key] = Diversion(request.key, *order, phase)
        if late:
            self._end(entry, phase)
        else:
            self._queue.append(entry)
        return phase, DiversionReason.NONE

    def _refusal(self, request: DiversionRequest) -> DiversionReason:
        """Return the first reason to refuse a diversion, in the order of docs/fieldbus.md, or `NONE`."""
        exists = 0 <= request.bin < len(self._bins)
        awaited = sum(entry.bin == request.bin for entry in self._queue)
        conditions = {
            DiversionReason.OTHER_COMMAND: request.key == 0,
            DiversionReason.OTHER_BOOT: request.boot != self._boot,
            DiversionReason.EMERGENCY_STOP: self._emergency_stop,
            DiversionReason.NO_SUCH_BIN: not exists,
            DiversionReason.ALREADY_DIVERTED: any(
                entry.object == request.object
                or abs(entry.coordinate - request.coordinate) <= self._machine.window
                for entry in self._memory.values()
            ),
            DiversionReason.BIN_FULL: exists and self._bins[request.bin] + awaited >= self._machine.capacity,
            DiversionReason.QUEUE_FULL: len(self._queue) >= self._machine.queue,
        }
        return next((reason for reason, holds in conditions.items() if holds), DiversionReason.NONE)

    def _move(self) -> None:
        """Bring the belt's position up to now."""
        self._now = self._clock()
        if self._moving:
            position, time = self._began
            self._position = position + round(self._machine.speed * (self._now - time))
        self._carry_out()

    def _carry_out(self) -> None:
        """Divert the objects that have come by their diverters."""
        for entry in list(self._queue):
            if self._position < entry.coordinate + self._machine.diverters[entry.bin]:
                continue
            self._queue.remove(entry)
            if self._emergency_stop:
                self._end(entry, DiversionPhase.NOT_DONE, DiversionReason.EMERGENCY_STOP)
            elif self._bins[entry.bin] >= self._machine.capacity:
                self._end(entry, DiversionPhase.NOT_DONE, DiversionReason.BIN_FULL)
            else:
                self._bins[entry.bin] += 1
                self._end(entry, DiversionPhase.DONE)

    def _end(
        self, entry: Diversion, phase: DiversionPhase, reason: DiversionReason = DiversionReason.NONE
    ) -> None:
        entry.phase, entry.reason = phase, reason
        self._ended(entry)
        self._forget()

    def _forget(self) -> None:
        """Remove the oldest ended diversions beyond the size of the memory; never a queued one."""
        ended = [key for key, entry in self._memory.items() if entry.phase is not DiversionPhase.QUEUED]
        for key in ended[: max(0, len(ended) - self._machine.memory)]:
            del self._memory[key]
            self._forgotten += 1
