"""The client's side: a belt and a sorter in one device, over any `Link`."""

import time
from collections.abc import Callable
from math import isfinite
from threading import Lock

from beltsort.cell.commands import TIMEOUT, CommandError, EmergencyStopError, Outcome, within
from beltsort.cell.controller.link import Connect, Conversation
from beltsort.cell.controller.wire import OUTCOMES, Phase, Reason, Reply, Verb, explained, key_of
from beltsort.cell.protocols import Health

COMMAND_POLL = 0.02
"""Seconds between two looks whether a command has ended."""

LAST_LOOK = 0.05
"""Seconds before a deadline after which no look is begun that would have to be broken off."""


class Deadline:
    """Seconds that are left of a timeout."""

    def __init__(self, timeout: float) -> None:
        if not (isfinite(timeout) and timeout > 0.0):
            raise CommandError(
                f"timeout is {timeout}, expected seconds above 0; give a number", Outcome.NOT_DONE
            )
        self.timeout = timeout
        self._end = time.monotonic() + timeout

    @property
    def left(self) -> float:
        """Seconds until the deadline, never 0: what is tried at the last moment may still succeed."""
        return max(1e-3, self._end - time.monotonic())

    @property
    def over(self) -> bool:
        """Whether the time is over."""
        return time.monotonic() >= self._end


class FieldbusDevice:
    """A belt and a sorter that one controller drives. Safe to use from several threads.

    Connects when first used. A connection that failed or hung is given up, never used again; the next call
    builds a new one.

    Parameters
    ----------
    connect
        Builds a connection.
    name
        Names the controller in errors.
    answer_timeout
        Seconds that the controller may take to acknowledge a request.
    clock
        The cell's clock, seconds.
    """

    def __init__(
        self, connect: Connect, name: str, answer_timeout: float, clock: Callable[[], float]
    ) -> None:
        self._connect = connect
        self._name = name
        self._answer_timeout = answer_timeout
        self._clock = clock
        self._lock = Lock()
        self._conversation: Conversation | None = None
        self._spoken: int | None = None
        self._first_boot: int | None = None
        self._sent: dict[str, tuple[int, int]] = {}  # (boot, forgotten) before each command that did not end

    def connect(self) -> None:
        """Connect now, to learn early whether it works."""
        self.health()

    def close(self) -> None:
        """Give the connection up; the next call would build a new one."""
        with self._lock:
            self._hang_up()

    def health(self) -> Health:
        """Say how the controller is. Raises `CommandError` if it cannot be reached."""
        reply = self._insist(Verb.LOOK, 0, 0, Deadline(TIMEOUT))
        return Health(
            ready=reply.ready,
            boot_id=f"{reply.boot:08x}",
            fault="" if reply.ready else explained(reply.fault or Reason.EMERGENCY_STOP),
            emergency_stop=reply.emergency_stop,
        )

    def stop(self) -> None:
        """End every motion now; a command that still acts ends with the outcome `UNKNOWN`."""
        self._insist(Verb.STOP, 0, 0, Deadline(TIMEOUT))

    def home(self, index: int, *, timeout: float = TIMEOUT) -> None:
        """Tell the controller that object number `index` is at the belt end.

        Call it after somebody has looked: before a run, after a restart of the controller, after a fault.
        """
        reply = self._insist(Verb.HOME, index, 0, Deadline(timeout))
        self._check(reply, f"homing to object {index}")

    def advance_to(self, index: int, command_id: str, *, timeout: float = TIMEOUT) -> float:
        """Bring object number `index` of the run to the belt end; return the time of its stop there.

        Seconds on the cell's clock, never too early.
        """
        return self._command(Verb.ADVANCE, index, command_id, f"the advance to object {index}", timeout)

    def sort(self, label: int, command_id: str, *, timeout: float = TIMEOUT) -> None:
        """Put the object at the belt end into bin number `label`."""
        self._command(Verb.SORT, label, command_id, f"the sort into bin {label}", timeout)

    def outcome_of(self, command_id: str) -> Outcome:
        """Tell what became of a command.

        `NOT_DONE` is final: asking makes the controller ignore whatever is still on its way. An id that the
        controller does not remember is `NOT_DONE` only if nothing can have been forgotten since it was sent.
        """
        reply = self._insist(Verb.RECALL, 0, key_of(command_id), Deadline(TIMEOUT))
        if reply.phase is not Phase.FORGOTTEN:
            return OUTCOMES[reply.phase]
        state = (reply.boot, reply.forgotten)
        if command_id in self._sent:
            never_arrived = self._sent[command_id] == state
        else:
            never_arrived = reply.remembered > 0 and state == (self._first_boot, 0)
        return Outcome.NOT_DONE if never_arrived else Outcome.UNKNOWN

    def _command(self, verb: Verb, target: int, command_id: str, what: str, timeout: float) -> float:
        """Carry out a command; return the time at which it ended."""
        deadline, key = Deadline(timeout), key_of(command_id)
        before = self._before(command_id, deadline)
        self._check_boot(command_id, before, what)
        self._sent[command_id] = (before.boot, before.forgotten)
        reply = self._once(verb, target, key, deadline, what)
        while reply.phase is Phase.RUNNING:
            if deadline.left < LAST_LOOK:
                raise CommandError(
                    f"{what} still acts after {timeout:g} s; stop it, or wait and ask what became of it",
                    Outcome.UNKNOWN,
                )
            time.sleep(COMMAND_POLL)
            reply = self._follow(key, deadline, what)
        self._check(reply, what)
        del self._sent[command_id]
        return self._clock() - reply.age / 1000.0

    def _check_boot(self, command_id: str, now: Reply, what: str) -> None:
        """Refuse to repeat a command that the controller may have carried out before it restarted."""
        boot, _ = self._sent.get(command_id, (now.boot, 0))
        if boot != now.boot:
            raise CommandError(
                f"{what} was sent before {self._name} restarted and may have been done, expected no "
                "repetition; look, call home(), and use another command id",
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
        where = "somewhere unknown" if reply.position < 0 else f"at object {reply.position}"
        kind = EmergencyStopError if reply.reason is Reason.EMERGENCY_STOP else CommandError
        raise kind(
            f"{what} ended as {reply.phase.name.lower().replace('_', ' ')}, expected done: "
            f"{explained(reply.reason)} (the belt is {where})",
            OUTCOMES[reply.phase],
        )

    def _before(self, command_id: str, deadline: Deadline) -> Reply:
        """Look before a command, over a connection that works."""
        try:
            return self._insist(Verb.LOOK, 0, 0, deadline)
        except CommandError as failure:
            if command_id not in self._sent:
                raise
            raise CommandError(f"{failure}; it was sent earlier", Outcome.UNKNOWN) from failure

    def _follow(self, key: int, deadline: Deadline, what: str) -> Reply:
        """Ask after a command that acts."""
        try:
            return self._insist(Verb.RECALL, 0, key, deadline)
        except CommandError as failure:
            raise CommandError(f"{what} was begun, then: {failure}", Outcome.UNKNOWN) from failure

    def _once(self, verb: Verb, target: int, key: int, deadline: Deadline, what: str) -> Reply:
        """Send a command over the connection at hand, never twice."""
        try:
            return self._exchange(verb, target, key, deadline)
        except Exception as failure:  # whatever the driver raises, the command may have arrived
            raise CommandError(f"{what} was sent, then: {failure}", Outcome.UNKNOWN) from failure

    def _insist(self, verb: Verb, target: int, key: int, deadline: Deadline) -> Reply:
        """Ask what may be asked twice; if an old connection fails, once more over a new one."""
        if self._conversation is not None:
            try:
                return self._exchange(verb, target, key, deadline)
            except Exception as failure:
                lost = failure
            if deadline.over:
                raise self._unreachable(lost) from lost
        try:
            return self._exchange(verb, target, key, deadline)
        except Exception as failure:
            raise self._unreachable(failure) from failure

    def _unreachable(self, failure: Exception) -> CommandError:
        return CommandError(
            f"{self._name} cannot be asked ({type(failure).__name__}: {failure}); check that it runs, its "
            "address and certificates",
            Outcome.NOT_DONE,
        )

    def _exchange(self, verb: Verb, target: int, key: int, deadline: Deadline) -> Reply:
        """Send one request over the connection at hand, or over a new one; hang up if it fails."""
        if not self._lock.acquire(timeout=deadline.left):
            raise TimeoutError("another thread's request takes too long")
        try:
            seconds = min(self._answer_timeout, deadline.left)
            if self._conversation is None:
                self._conversation = within(seconds, "connecting", lambda: self._dial(seconds))
            conversation = self._conversation
            seconds = min(seconds, deadline.left)
            reply = within(seconds, "the answer", lambda: conversation.ask(verb, target, key, seconds))
        except BaseException:
            self._hang_up()
            raise
        finally:
            self._lock.release()
        if self._first_boot is None:
            self._first_boot = reply.boot
        return reply

    def _dial(self, seconds: float) -> Conversation:
        """Build a new connection, and close it at once if nobody waits for it any more."""
        end = time.monotonic() + seconds
        link = self._connect(seconds)
        try:
            conversation = Conversation(link, self._spoken)
        except BaseException:
            link.close()
            raise
        if time.monotonic() > end:
            link.close()
        return conversation

    def _hang_up(self) -> None:
        if self._conversation is not None:
            self._spoken = self._conversation.sequence
            self._conversation.close()
            self._conversation = None
