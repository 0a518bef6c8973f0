"""A sorter with a service for each bin."""

import time
from dataclasses import dataclass, replace

from beltsort.cell.commands import TIMEOUT, CommandError, EmergencyStopError, Outcome
from beltsort.cell.protocols import Health
from beltsort.drivers.deadline import Deadline
from beltsort.drivers.ros.device import HEALTH_TIMEOUT, Received, RosDevice, emergency_stop
from beltsort.drivers.ros.ledger import Ledger
from beltsort.drivers.ros.link import Topics
from beltsort.drivers.ros2.link import Ros2Link
from beltsort.drivers.ros2.options import Ros2ServiceSorterOptions
from beltsort.drivers.ros2.trigger import Answer, Stopping, StopTopic, Trigger

POLL_INTERVAL = 0.05
"""Interval at which an answer is looked for, seconds."""


@dataclass(frozen=True)
class Call:
    """A call of a service: the command, the sorter's boot id, and its count before, None if it has none."""

    command_id: str
    trigger: Trigger
    boot_id: str
    count: int | None


class Ros2ServiceSorter(RosDevice):
    """A sorter on ROS 2 with a std_srvs/Trigger for each bin.

    A call says not which command it belongs to, and a sort must not be executed twice, so a call is never
    repeated. What became of it is known from its answer, or, if that was lost, from the number of sorted
    objects that the sorter reports. Without such a report it stays unknown, and a person is asked.

    Parameters
    ----------
    options
        Its services and topics.
    """

    def __init__(self, options: Ros2ServiceSorterOptions) -> None:
        self._bins = {number: Trigger(service) for number, service in options.services.items()}
        self._stopping: Stopping = (
            Trigger(options.stop_service) if options.stop_service else StopTopic(options.stop_topic)
        )
        services = {name: kind for bin_ in self._bins.values() for name, kind in bin_.topics.services.items()}
        topics = Topics(
            publish=self._stopping.topics.publish,
            subscribe={
                **({options.count_topic: "std_msgs/Int32"} if options.count_topic else {}),
                **emergency_stop(options),
            },
            services={**services, **self._stopping.topics.services},
        )
        link = Ros2Link(options, "sorter", topics)
        name = options.count_topic or next(iter(options.services.values()))
        super().__init__(link, name, options.emergency_stop_topic)
        self._counts = bool(options.count_topic)
        self._ledger = Ledger()
        self._last: Call | None = None

    def stop(self) -> None:
        """Command the sorter to stop."""
        self.connect()
        deadline = self._soon(HEALTH_TIMEOUT)
        self._link.send(self._stopping.request(), deadline)
        self._stopping.confirm(self._link, deadline)

    def health(self) -> Health:
        """Return the sorter's state; it is not ready while an earlier call may still be carried out.

        Without a report of the number of sorted objects it is taken to be ready if all services are there.
        """
        health = super().health() if self._counts else self._served()
        if health.ready and (doubt := self._doubt(health.boot_id)):
            return replace(health, ready=False, fault=doubt)
        return health

    def outcome_of(self, command_id: str, _boot_id: str = "", /) -> Outcome:
        """Return the outcome of a command, from a late answer or the number of sorted objects if need be."""
        if command_id not in self._ledger:
            return Outcome.UNKNOWN
        outcome = self._ledger[command_id].outcome
        if outcome is not Outcome.UNKNOWN or self._last is None or self._last.command_id != command_id:
            return outcome
        try:
            self.connect()
            return self._asked(self._last, self._soon(HEALTH_TIMEOUT))
        except CommandError:
            return Outcome.UNKNOWN

    def sort(self, label: int, command_id: str, *, timeout: float = TIMEOUT) -> None:
        """Put the object at the belt end into bin number `label`.

        Raises
        ------
        CommandError
            If the sorter refuses, cannot be reached, or does not answer in time. A command whose outcome is
            unknown is not sent again.
        """
        unresolved = command_id in self._ledger and self._ledger[command_id].outcome is Outcome.UNKNOWN

        def act() -> float:
            deadline = Deadline(timeout)
            self._link.connect(deadline.left())
            if unresolved and (stop := self._earlier(command_id, deadline)) is not None:
                return stop
            return self._end(self._begin(label, command_id, deadline), deadline)

        self._ledger.once("sort", label, command_id, act)

    def _begin(self, label: int, command_id: str, deadline: Deadline) -> Call:
        """Call the service of a bin if the sorter is ready."""
        if label not in self._bins:
            raise CommandError(
                f"services has none for bin {label}, expected one of {sorted(self._bins)}; add it",
                Outcome.NOT_DONE,
            )
        health = self.health()
        if not health.ready:
            kind = EmergencyStopError if health.emergency_stop else CommandError
            raise kind(f"the sorter takes no commands: {health.fault}", Outcome.NOT_DONE)
        call = Call(command_id, self._bins[label], health.boot_id, self._count_before(deadline))
        self._last = call
        try:
            self._link.send(call.trigger.request(), deadline)
        except CommandError as failure:
            if failure.outcome is Outcome.NOT_DONE:  # nothing was sent
                self._last = None
            raise
        return call

    def _count_before(self, deadline: Deadline) -> int | None:
        """Return the number of sorted objects of a sorter at rest; None if it does not report it."""
        if not self._counts:
            return None
        state = self._current(deadline)
        while state is not None:
            if state.message["data"] >= 0:
                return int(state.message["data"])
            state = self._await(deadline, state.number)
        raise CommandError(
            f"the sorter was not at rest within {deadline.timeout:g} s, expected a number of sorted objects "
            f"on {self._topic}; check it",
            Outcome.NOT_DONE,
        )

    def _end(self, call: Call, deadline: Deadline) -> float:
        """Wait for the end of a call; return the time, seconds."""
        while deadline.left() > 0.0:
            answer = call.trigger.answer(self._link, deadline, wait=POLL_INTERVAL)
            state = self._current(deadline) if self._counts else None  # not from before the answer
            outcome = outcome_of_call(call, answer, state, counts=self._counts)
            if outcome is Outcome.DONE:
                return time.monotonic()
            if outcome in (Outcome.NOT_DONE, Outcome.BROKEN_OFF):
                raise self._failed(call, answer, outcome)
            self._check_emergency_stop(deadline, Outcome.UNKNOWN)
        raise CommandError(
            f"{call.trigger.service} was called and did not end within {deadline.timeout:g} s; check the "
            "sorter and ask for the outcome",
            Outcome.UNKNOWN,
        )

    def _earlier(self, command_id: str, deadline: Deadline) -> float | None:
        """Return the end of an earlier call of a command; None if nothing came of it.

        Raises
        ------
        CommandError
            `UNKNOWN` if that is not known: the service is not called again.
        """
        call = self._last
        if call is None or call.command_id != command_id:
            raise CommandError(
                f"command {command_id!r} was sent before a later one, and what came of it is not known; "
                "check where the object is, and use a new id",
                Outcome.UNKNOWN,
            )
        outcome = self._asked(call, deadline)
        if outcome is Outcome.NOT_DONE:
            return None
        if outcome in (Outcome.DONE, Outcome.RUNNING):
            return time.monotonic() if outcome is Outcome.DONE else self._end(call, deadline)
        restarted = self.health().boot_id != call.boot_id
        raise CommandError(
            f"command {command_id!r} was sent"
            + (" before the sorter was restarted" if restarted else "")
            + ", and what came of it is not known; check where the object is, and use a new id",
            Outcome.UNKNOWN,
        )

    def _asked(self, call: Call, deadline: Deadline) -> Outcome:
        """Return the outcome of a call, from its answer and the newest report."""
        state = self._current(deadline) if self._counts else None
        answer = call.trigger.answer(self._link, deadline)
        return outcome_of_call(call, answer, state, counts=self._counts)

    def _failed(self, call: Call, answer: Answer | None, outcome: Outcome) -> CommandError:
        says = f"{call.trigger.service} says: {answer.message}" if answer is not None else "no answer came"
        if outcome is Outcome.NOT_DONE:
            return CommandError(f"the sorter refused: {says}; resolve this and repeat", outcome)
        return CommandError(f"the sorter broke the sort off: {says}; check where the object is", outcome)

    def _served(self) -> Health:
        """Return whether every service has a server; their identities are the boot id."""
        self.connect()
        deadline = self._soon(HEALTH_TIMEOUT)
        while True:
            found = {bin_.service: self._server(bin_.service, deadline) for bin_ in self._bins.values()}
            missing = [service for service, identity in found.items() if not identity]
            if not missing or deadline.left() == 0.0:
                break
            time.sleep(min(POLL_INTERVAL, deadline.left()))
        fault = f"no server of {', '.join(missing)}; start the sorter, or correct the name" if missing else ""
        return self._health(" ".join(found.values()), fault)

    def _server(self, service: str, deadline: Deadline) -> str:
        answer = self._link.ask("server", deadline.left() + HEALTH_TIMEOUT, service=service)
        return str(answer.values["identity"])

    def _doubt(self, boot_id: str) -> str:
        """Return why the sorter may still carry out an earlier call; empty if it does not."""
        call = self._last
        if call is None or boot_id != call.boot_id:
            return ""
        deadline = self._soon(HEALTH_TIMEOUT)
        if call.trigger.answer(self._link, deadline) is not None:
            return ""
        if self._counts and self._asked(call, deadline) is Outcome.DONE:
            return ""
        return (
            f"{call.trigger.service} was called, has not answered, and may still act; if it does not, start "
            "its node again"
        )


def outcome_of_call(call: Call, answer: Answer | None, state: Received | None, *, counts: bool) -> Outcome:
    """Return what became of a call.

    Parameters
    ----------
    call
        The call.
    answer
        Its answer; None if there is none.
    state
        The newest report of the number of sorted objects; negative if the sorter is not at rest.
    counts
        Whether the sorter reports it.
    """
    if not counts:
        if answer is None:
            return Outcome.UNKNOWN
        return Outcome.DONE if answer.success else Outcome.NOT_DONE
    if state is None or call.count is None or state.node not in ("", call.boot_id):
        return Outcome.UNKNOWN
    count, refused = state.message["data"], answer is not None and not answer.success
    if count == call.count + 1:
        return Outcome.DONE
    if count == call.count and refused:
        return Outcome.NOT_DONE
    if count < 0:
        return Outcome.BROKEN_OFF if refused else Outcome.RUNNING
    return Outcome.UNKNOWN
