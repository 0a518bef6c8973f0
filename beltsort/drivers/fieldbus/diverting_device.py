"""The client of a controller whose belt never stops, over any `Link`.

`docs/fieldbus.md`, "A belt that never stops", specifies the rules.
"""

from collections import OrderedDict
from collections.abc import Callable
from math import isfinite
from threading import Lock

from beltsort.cell.commands import TIMEOUT, CommandError, Outcome
from beltsort.cell.diverting import BeltReading, Diversion, DiversionStatus
from beltsort.cell.protocols import Health
from beltsort.drivers.clock_bounds import ClockBounds
from beltsort.drivers.deadline import Deadline, checked_deadline
from beltsort.drivers.fieldbus.diversions import (
    DIVERSION_EXPLANATIONS,
    DiversionPhase,
    DiversionReason,
    DiversionReply,
    DiversionRequest,
    DiversionVerb,
)
from beltsort.drivers.fieldbus.link import MissingPartError
from beltsort.drivers.fieldbus.reconnecting import Connect, ReconnectingLink, unanswered
from beltsort.drivers.fieldbus.wire import MEMORY, UNNUMBERED, boot_id_of, key_of
from beltsort.errors import CellError

MICRO = 1e-6
"""The unit of lengths and times of the protocol, in metres and seconds."""

FARTHEST = 1e12
"""Largest coordinate, metres; in micrometres it fits into 64 bits."""

NUMBERS = 2**31
"""Object and bin numbers are below this."""

STATES = {
    DiversionPhase.UNKNOWN: Diversion.UNKNOWN,
    DiversionPhase.QUEUED: Diversion.QUEUED,
    DiversionPhase.DONE: Diversion.DONE,
    DiversionPhase.NOT_DONE: Diversion.NOT_DONE,
    DiversionPhase.TOO_LATE: Diversion.TOO_LATE,
}

PASSING = frozenset({DiversionReason.EMERGENCY_STOP, DiversionReason.BIN_FULL, DiversionReason.QUEUE_FULL})
"""Reasons of refusals that may pass, so that it makes sense to send the diversion again."""


class DivertingDevice:
    """A belt that never stops, with its diverters, driven by a controller: a `DivertingBelt`. Thread-safe.

    It connects on first use. A connection that failed or timed out is closed, and the next call opens a new
    one. Every call but `divert` and `diversion` raises `CommandError` with the outcome `NOT_DONE` if the
    controller cannot be asked, and all raise `CellError` if it has no diversions. A controller that has had
    them counts as one that cannot be asked: its program has not started yet.

    Parameters
    ----------
    connect
        Opens a connection.
    address
        Address of the controller, for error messages and for the lock of the device.
    answer_timeout
        Timeout of the acknowledgement of a request, seconds.
    clock
        The cell's clock, seconds.
    """

    def __init__(
        self,
        connect: Connect[DiversionRequest, DiversionReply],
        address: str,
        answer_timeout: float,
        clock: Callable[[], float],
    ) -> None:
        self._link = ReconnectingLink(connect, answer_timeout, address)
        self.address = address
        self._name = f"the controller at {address}"
        self._clock = clock
        self._lock = Lock()
        self._has_diversions = False
        self._bounds: tuple[int, ClockBounds] | None = None  # of the clock since a boot id
        # For each diversion that is not known to have ended: boot id and number of forgotten diversions
        # before it was sent.
        self._sent: OrderedDict[str, tuple[int, int]] = OrderedDict()

    def connect(self) -> None:
        """Connect now, to detect errors early."""
        self.health()

    def close(self) -> None:
        """Close the connection; the next call opens a new one."""
        self._link.close()

    def health(self) -> Health:
        """Return the controller's health; it accepts diversions also while the belt stands."""
        reply = self._ask(DiversionRequest(UNNUMBERED, DiversionVerb.LOOK), Deadline(TIMEOUT), "looking")
        pressed = reply.emergency_stop
        fault = DIVERSION_EXPLANATIONS[DiversionReason.EMERGENCY_STOP] if pressed else ""
        return Health(not pressed, boot_id_of(reply.boot), fault, emergency_stop=pressed)

    def stop(self) -> None:
        """Stop the belt; what is queued stays queued."""
        self._ask(DiversionRequest(UNNUMBERED, DiversionVerb.STOP), Deadline(TIMEOUT), "stopping")

    def reading(self, *, timeout: float = TIMEOUT) -> BeltReading:
        """Return how far the belt has moved, as `DivertingBelt.reading` says."""
        deadline, sent = checked_deadline(timeout), self._clock()
        look = DiversionRequest(UNNUMBERED, DiversionVerb.LOOK)
        reply = self._ask(look, deadline, "reading the encoder")
        stamp = MICRO * reply.stamp
        bounds = self._narrowed(reply.boot, ClockBounds.of(sent, self._clock(), stamp))
        return BeltReading(
            stamp + bounds.offset,
            MICRO * reply.position,
            boot_id_of(reply.boot),
            reply.moving,
            reply.emergency_stop,
            bounds.error,
        )

    def divert(
        self,
        command_id: str,
        *,
        number: int,
        coordinate: float,
        label: int,
        boot_id: str,
        timeout: float = TIMEOUT,
    ) -> DiversionStatus:
        """Queue a diversion, as `DivertingBelt.divert` says; `label` is the controller's number of the bin.

        `retry` is set if the reason of the refusal may pass: emergency stop, full bin, full queue.
        """
        what = f"the diversion of object {number} into bin {label}"
        deadline = checked_deadline(timeout)
        request = DiversionRequest(
            UNNUMBERED,
            DiversionVerb.DIVERT,
            key_of(command_id),
            _number("object", number, what),
            _micrometres(coordinate, what),
            _number("bin", label, what),
            _boot(boot_id, what),
        )
        recall = DiversionRequest(UNNUMBERED, DiversionVerb.RECALL, request.key)
        before = self._ask(recall, deadline, what, self._lost(command_id))
        self._remember(command_id, (before.boot, before.forgotten))
        reply = self._ask(request, deadline, what, Outcome.UNKNOWN)
        retry = False
        if reply.phase is DiversionPhase.NOT_DONE and reply.reason in PASSING:
            # The reason is that of a refusal, or the outcome of a diversion that was queued.
            retry = self._ask(recall, deadline, what, Outcome.UNKNOWN).phase is DiversionPhase.UNKNOWN
        return self._status(command_id, reply, retry=retry)

    def diversion(self, command_id: str, *, boot_id: str, timeout: float = TIMEOUT) -> DiversionStatus:
        """Return the state of a diversion, as `DivertingBelt.diversion` says."""
        what = f"asking for the diversion {command_id!r}"
        recall = DiversionRequest(UNNUMBERED, DiversionVerb.RECALL, key_of(command_id))
        reply = self._ask(recall, checked_deadline(timeout), what, Outcome.UNKNOWN)
        if reply.phase is DiversionPhase.UNKNOWN and self._never_arrived(command_id, boot_id, reply):
            reason = "the controller has not received it; send it again"
            return DiversionStatus(Diversion.NOT_DONE, boot_id_of(reply.boot), reason, retry=True)
        return self._status(command_id, reply)

    def _status(self, command_id: str, reply: DiversionReply, *, retry: bool = False) -> DiversionStatus:
        """Return what a reply says of a diversion, which is no longer kept if that is final."""
        state = STATES[reply.phase]
        if reply.reason is DiversionReason.OTHER_BOOT:
            state = Diversion.UNKNOWN  # it may have been carried out before the restart
        if state.final:
            with self._lock:
                self._sent.pop(command_id, None)
        explained = DIVERSION_EXPLANATIONS[reply.reason] if reply.reason else ""
        return DiversionStatus(state, boot_id_of(reply.boot), explained, retry)

    def _never_arrived(self, command_id: str, boot_id: str, reply: DiversionReply) -> bool:
        """Return whether a diversion that the controller does not remember cannot have been forgotten.

        Once a controller has forgotten one, its memory is full, and it forgets the next ones in their order.
        """
        if boot_id_of(reply.boot) != boot_id:
            return False
        with self._lock:
            boot, before = self._sent.get(command_id, (reply.boot, 0))
        since = reply.forgotten - before
        return boot == reply.boot and (since == 0 or (before > 0 and 0 < since < MEMORY))

    def _lost(self, command_id: str) -> Outcome:
        """Return the outcome of a diversion that is not sent now: it may have been sent before."""
        with self._lock:
            return Outcome.UNKNOWN if command_id in self._sent else Outcome.NOT_DONE

    def _remember(self, command_id: str, state: tuple[int, int]) -> None:
        with self._lock:
            self._sent.setdefault(command_id, state)
            while len(self._sent) > MEMORY:
                self._sent.popitem(last=False)

    def _narrowed(self, boot: int, bounds: ClockBounds) -> ClockBounds:
        """Return the bounds of the clock's offset after a round trip; they begin anew with each boot id."""
        with self._lock:
            if self._bounds is not None and self._bounds[0] == boot:
                bounds = self._bounds[1].narrowed(bounds)
            self._bounds = (boot, bounds)
        return bounds

    def _ask(
        self, request: DiversionRequest, deadline: Deadline, what: str, lost: Outcome = Outcome.NOT_DONE
    ) -> DiversionReply:
        """Send a request, all of which may be repeated; `lost` is the outcome if there is no reply."""
        try:
            reply = self._link.send_repeatable(request, deadline)
        except Exception as failure:  # any exception of the fieldbus library
            if isinstance(failure, MissingPartError) and not self._has_diversions:
                raise CellError(
                    f"{what}: {self._name} has no diversions ({failure}), expected those of "
                    'docs/fieldbus.md, "A belt that never stops"; add them to its program, or use a belt '
                    "that stops"
                ) from failure
            raise unanswered(what, self._name, failure, lost) from failure
        self._has_diversions = True
        return reply


def _number(name: str, value: int, what: str) -> int:
    if not 0 <= value < NUMBERS:
        raise _senseless(what, f"{name} is {value}, expected 0 to {NUMBERS - 1}")
    return value


def _micrometres(coordinate: float, what: str) -> int:
    if not (isfinite(coordinate) and abs(coordinate) <= FARTHEST):
        raise _senseless(what, f"coordinate is {coordinate}, expected at most {FARTHEST:g} m")
    return round(coordinate / MICRO)


def _boot(boot_id: str, what: str) -> int:
    """Return the controller's number of a boot id."""
    try:
        boot = int(boot_id, 16)
    except ValueError:
        boot = 0
    if not 0 < boot < 2**63:
        raise _senseless(what, f"boot_id is {boot_id!r}, expected that of a reading of this controller")
    return boot


def _senseless(what: str, problem: str) -> CommandError:
    return CommandError(f"{what}: {problem}; nothing was sent, correct it", Outcome.NOT_DONE)
