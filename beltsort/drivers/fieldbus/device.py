"""The client's side: a belt and a sorter in one device, over any `Link`."""

import time
from collections.abc import Callable

from beltsort.cell.commands import TIMEOUT, CommandError, EmergencyStopError, Outcome
from beltsort.cell.protocols import NOWHERE, Health
from beltsort.drivers.fieldbus.line import Connect, Deadline, Line
from beltsort.drivers.fieldbus.link import Order
from beltsort.drivers.fieldbus.wire import NEED_HOME, OUTCOMES, Phase, Reason, Reply, Verb, explained, key_of

COMMAND_POLL = 0.02
"""Seconds between two looks whether a command has ended."""

LAST_LOOK = 0.05
"""Seconds before a deadline after which no look is begun that would have to be broken off."""


class FieldbusDevice:
    """A belt and a sorter that one controller drives. Safe to use from several threads.

    Connects when first used. A connection that failed or hung is given up, never used again; the next call
    builds a new one.

    Parameters
    ----------
    connect
        Builds a connection.
    address
        Names the controller in errors, and to the lock that lets only one run drive it.
    answer_timeout
        Seconds that the controller may take to acknowledge a request.
    clock
        The cell's clock, seconds.
    """

    def __init__(
        self, connect: Connect, address: str, answer_timeout: float, clock: Callable[[], float]
    ) -> None:
        self._line = Line(connect, answer_timeout)
        self.address = address
        self._name = f"the controller at {address}"
        self._clock = clock
        self._sent: dict[str, tuple[int, int]] = {}  # (boot, forgotten) before each command not done

    def connect(self) -> None:
        """Connect now, to learn early whether it works."""
        self.health()

    def close(self) -> None:
        """Give the connection up; the next call would build a new one."""
        self._line.close()

    def health(self) -> Health:
        """Say how the controller is. Raises `CommandError` if it cannot be reached."""
        reply = self._ask(Order(Verb.LOOK), Deadline(TIMEOUT), "looking")
        fault = reply.fault or (Reason.EMERGENCY_STOP if reply.emergency_stop else Reason.NONE)
        return Health(
            ready=reply.ready,
            boot_id=_boot_id(reply),
            fault="" if reply.ready else explained(fault),
            emergency_stop=reply.emergency_stop,
            needs_home=reply.fault in NEED_HOME,
        )

    def stop(self) -> None:
        """End every motion now; a command that still acts ends with the outcome `UNKNOWN`."""
        self._ask(Order(Verb.STOP), Deadline(TIMEOUT), "stopping")

    def home(self, index: int, *, timeout: float = TIMEOUT) -> None:
        """Tell the controller that object number `index` is at the belt end.

        Only after somebody has looked: when the controller was started, or after a fault.
        """
        what = f"homing to object {index}"
        self._check(self._ask(Order(Verb.HOME, index), Deadline(timeout), what), what)

    def advance_to(self, index: int, command_id: str, *, timeout: float = TIMEOUT) -> float:
        """Bring object number `index` of the run to the belt end; return the time of its stop there.

        Seconds on the cell's clock, never too early.
        """
        order = Order(Verb.ADVANCE, index, key_of(command_id))
        return self._command(order, command_id, f"the advance to object {index}", timeout)

    def sort(self, label: int, command_id: str, *, timeout: float = TIMEOUT) -> None:
        """Put the object at the belt end into bin number `label`."""
        order = Order(Verb.SORT, label, key_of(command_id))
        self._command(order, command_id, f"the sort into bin {label}", timeout)

    def position(self) -> int:
        """Return the number of the object at the belt end, or `NOWHERE`."""
        return self._ask(Order(Verb.LOOK), Deadline(TIMEOUT), "looking").position

    def outcome_of(self, command_id: str, boot_id: str = "", /) -> Outcome:
        """Tell what became of a command.

        `NOT_DONE` is final: asking makes the controller ignore whatever is still on its way. An id that the
        controller does not remember is `NOT_DONE` only if nothing can have been forgotten since it was sent.
        """
        what = f"asking what became of {command_id!r}"
        recall = Order(Verb.RECALL, key=key_of(command_id))
        reply = self._ask(recall, Deadline(TIMEOUT), what, Outcome.UNKNOWN)
        if reply.phase is not Phase.FORGOTTEN:
            return OUTCOMES[reply.phase]
        if command_id in self._sent:
            never_arrived = self._sent[command_id] == (reply.boot, reply.forgotten)
        else:
            never_arrived = (_boot_id(reply), reply.forgotten) == (boot_id, 0)
        return Outcome.NOT_DONE if never_arrived else Outcome.UNKNOWN

    def _command(self, order: Order, command_id: str, what: str, timeout: float) -> float:
        """Carry out a command; return the time at which it ended."""
        deadline, recall = Deadline(timeout), Order(Verb.RECALL, key=order.key)
        lost = Outcome.UNKNOWN if command_id in self._sent else Outcome.NOT_DONE
        self._note(command_id, self._ask(recall, deadline, what, lost), what)
        reply = self._order(order, deadline, what)
        while reply.phase is Phase.RUNNING:
            if deadline.left < LAST_LOOK:
                raise CommandError(
                    f"{what} still acts after {timeout:g} s; stop it, or wait and ask what became of it",
                    Outcome.RUNNING,
                )
            time.sleep(COMMAND_POLL)
            reply = self._ask(recall, deadline, what, Outcome.UNKNOWN)
        self._check(reply, what)
        self._sent.pop(command_id, None)
        return self._clock() - reply.age / 1000.0

    def _note(self, command_id: str, before: Reply, what: str) -> None:
        """Note when a command is first sent; refuse to repeat one that may have acted and been forgotten."""
        state = (before.boot, before.forgotten)
        if self._sent.setdefault(command_id, state) != state and before.phase is Phase.FORGOTTEN:
            raise CommandError(
                f"{what} was sent before; {self._name} has since restarted or forgotten it, and it may have "
                "been done, expected no repetition; look, and use another command id",
                Outcome.UNKNOWN,
            )

    def _check(self, reply: Reply, what: str) -> None:
        """Raise what the controller says of a command that is not done."""
        if reply.phase is Phase.DONE:
            return
        if reply.phase is Phase.FORGOTTEN:
            raise CommandError(
                f"{self._name} was restarted during {what} and has forgotten it; look what became of it",
                Outcome.UNKNOWN,
            )
        where = "at no object" if reply.position == NOWHERE else f"at object {reply.position}"
        kind = EmergencyStopError if reply.reason == Reason.EMERGENCY_STOP else CommandError
        raise kind(
            f"{what} ended as {reply.phase.name.lower().replace('_', ' ')}, expected done: "
            f"{explained(reply.reason)} (the belt is {where})",
            OUTCOMES[reply.phase],
        )

    def _ask(self, order: Order, deadline: Deadline, what: str, lost: Outcome = Outcome.NOT_DONE) -> Reply:
        """Ask what may be asked twice; without an answer, the outcome of what it is asked for is `lost`."""
        try:
            return self._line.insist(order, deadline)
        except Exception as failure:  # whatever the driver raises
            raise CommandError(
                f"{what}: {self._name} cannot be asked ({type(failure).__name__}: {failure}); check that it "
                "runs, its address and certificates",
                lost,
            ) from failure

    def _order(self, order: Order, deadline: Deadline, what: str) -> Reply:
        """Send a command, never twice."""
        try:
            return self._line.send(order, deadline)
        except Exception as failure:  # whatever the driver raises, the command may have arrived
            raise CommandError(
                f"{what} was sent, then: {type(failure).__name__}: {failure}; ask what became of it",
                Outcome.UNKNOWN,
            ) from failure


def _boot_id(reply: Reply) -> str:
    return f"{reply.boot:08x}"
