"""The client of a controller that drives belt and sorter, over any `Link`."""

import time
from collections.abc import Callable

from beltsort.cell.commands import TIMEOUT, CommandError, EmergencyStopError, Outcome
from beltsort.cell.protocols import NOWHERE, Health
from beltsort.drivers.deadline import Deadline, checked_deadline
from beltsort.drivers.fieldbus.reconnecting import Connect, ReconnectingLink, unanswered
from beltsort.drivers.fieldbus.wire import (
    NEED_HOME,
    OUTCOMES,
    UNNUMBERED,
    Phase,
    Reason,
    Reply,
    Request,
    Verb,
    boot_id_of,
    explained,
    key_of,
)

COMMAND_POLL = 0.02
"""Interval at which a running command is polled, seconds."""

LAST_POLL = 0.05
"""No poll is started within this time before the deadline, seconds."""


class FieldbusDevice:
    """A belt and a sorter driven by one controller. Thread-safe.

    It connects on first use. A connection that failed or timed out is closed, and the next call opens a new
    one.

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
        connect: Connect[Request, Reply],
        address: str,
        answer_timeout: float,
        clock: Callable[[], float],
    ) -> None:
        self._link = ReconnectingLink(connect, answer_timeout, address)
        self.address = address
        self._name = f"the controller at {address}"
        self._clock = clock
        # For each command not known to be done: boot id and number of forgotten commands before it was sent.
        self._sent: dict[str, tuple[int, int]] = {}

    def connect(self) -> None:
        """Connect now, to detect errors early."""
        self.health()

    def close(self) -> None:
        """Close the connection; the next call opens a new one."""
        self._link.close()

    def health(self) -> Health:
        """Return the controller's health. Raises `CommandError` if it cannot be reached."""
        reply = self._ask(Request(UNNUMBERED, Verb.LOOK), Deadline(TIMEOUT), "looking")
        fault = reply.fault or (Reason.EMERGENCY_STOP if reply.emergency_stop else Reason.NONE)
        return Health(
            ready=reply.ready,
            boot_id=boot_id_of(reply.boot),
            fault="" if reply.ready else explained(fault),
            emergency_stop=reply.emergency_stop,
            needs_home=reply.fault in NEED_HOME,
        )

    def stop(self) -> None:
        """Stop every motion."""
        self._ask(Request(UNNUMBERED, Verb.STOP), Deadline(TIMEOUT), "stopping")

    def home(self, index: int, *, timeout: float = TIMEOUT) -> None:
        """Set the number of the object at the belt end.

        Call this only after an operator has checked it: when the controller was started, or after a fault.
        """
        what = f"homing to object {index}"
        self._check(self._ask(Request(UNNUMBERED, Verb.HOME, index), checked_deadline(timeout), what), what)

    def advance_to(self, index: int, command_id: str, *, timeout: float = TIMEOUT) -> float:
        """Advance the belt until object `index` is at the belt end; return the time at which it stopped.

        The time is in seconds on the cell's clock; the delay of the reply can only make it too late.
        """
        request = Request(UNNUMBERED, Verb.ADVANCE, index, key_of(command_id))
        return self._command(request, command_id, f"the advance to object {index}", timeout)

    def sort(self, label: int, command_id: str, *, timeout: float = TIMEOUT) -> None:
        """Put the object at the belt end into bin number `label`."""
        request = Request(UNNUMBERED, Verb.SORT, label, key_of(command_id))
        self._command(request, command_id, f"the sort into bin {label}", timeout)

    def position(self) -> int:
        """Return the number of the object at the belt end, or `NOWHERE`."""
        return self._ask(Request(UNNUMBERED, Verb.LOOK), Deadline(TIMEOUT), "looking").position

    def outcome_of(self, command_id: str, boot_id: str = "", /) -> Outcome:
        """Return the outcome of a command.

        `NOT_DONE` is final: the controller ignores earlier requests that arrive after this one. For an id
        that it does not remember, the outcome is `NOT_DONE` if it cannot have forgotten it, else `UNKNOWN`.
        """
        what = f"asking for the outcome of {command_id!r}"
        recall = Request(UNNUMBERED, Verb.RECALL, key=key_of(command_id))
        reply = self._ask(recall, Deadline(TIMEOUT), what, Outcome.UNKNOWN)
        if reply.phase is not Phase.FORGOTTEN:
            return OUTCOMES[reply.phase]
        if command_id in self._sent:
            never_arrived = self._sent[command_id] == (reply.boot, reply.forgotten)
        else:
            never_arrived = (boot_id_of(reply.boot), reply.forgotten) == (boot_id, 0)
        return Outcome.NOT_DONE if never_arrived else Outcome.UNKNOWN

    def _command(self, request: Request, command_id: str, what: str, timeout: float) -> float:
        """Send a command and wait for its end; return the time of its end, seconds on the cell's clock."""
        deadline, recall = checked_deadline(timeout), Request(UNNUMBERED, Verb.RECALL, key=request.key)
        lost = Outcome.UNKNOWN if command_id in self._sent else Outcome.NOT_DONE
        self._check_repeatable(command_id, self._ask(recall, deadline, what, lost), what)
        reply = self._send_command(request, deadline, what)
        while reply.phase is Phase.RUNNING:
            if deadline.left() < LAST_POLL:
                raise CommandError(
                    f"{what} is still running after {timeout:g} s, expected its end; stop it, or wait and "
                    "ask for its outcome",
                    Outcome.RUNNING,
                )
            time.sleep(COMMAND_POLL)
            reply = self._ask(recall, deadline, what, Outcome.UNKNOWN)
        self._check(reply, what)
        self._sent.pop(command_id, None)
        return self._clock() - reply.age / 1000.0

    def _check_repeatable(self, command_id: str, before: Reply, what: str) -> None:
        """Raise an error for a repeated command that may have been executed and then forgotten."""
        state = (before.boot, before.forgotten)
        if self._sent.setdefault(command_id, state) != state and before.phase is Phase.FORGOTTEN:
            raise CommandError(
                f"{what} was sent before, and {self._name} has since restarted or forgotten it, so it may "
                "have been done; check the cell, and use another command id",
                Outcome.UNKNOWN,
            )

    def _check(self, reply: Reply, what: str) -> None:
        """Raise an error with the controller's reason unless the command is done."""
        if reply.phase is Phase.DONE:
            return
        if reply.phase is Phase.FORGOTTEN:
            raise CommandError(
                f"{self._name} was restarted during {what} and has forgotten it, expected its outcome; check "
                "the cell",
                Outcome.UNKNOWN,
            )
        where = "at no object" if reply.position == NOWHERE else f"at object {reply.position}"
        kind = EmergencyStopError if reply.reason == Reason.EMERGENCY_STOP else CommandError
        raise kind(
            f"{what} ended as {reply.phase.name.lower().replace('_', ' ')}, expected done: "
            f"{explained(reply.reason)} (the belt is {where})",
            OUTCOMES[reply.phase],
        )

    def _ask(
        self, request: Request, deadline: Deadline, what: str, lost: Outcome = Outcome.NOT_DONE
    ) -> Reply:
        """Send a request that may be repeated; `lost` is the outcome of the error if there is no reply."""
        try:
            return self._link.send_repeatable(request, deadline)
        except Exception as failure:  # any exception of the fieldbus library
            raise unanswered(what, self._name, failure, lost) from failure

    def _send_command(self, request: Request, deadline: Deadline, what: str) -> Reply:
        """Send a command, which must not be repeated."""
        try:
            return self._link.send(request, deadline)
        except Exception as failure:  # any exception of the fieldbus library; the command may have arrived
            raise CommandError(
                f"{what} was sent, then: {type(failure).__name__}: {failure}; ask for its outcome",
                Outcome.UNKNOWN,
            ) from failure
