"""A sorter that remembers keys of commands."""

from itertools import count, takewhile

from beltsort.cell.commands import TIMEOUT, CommandError, EmergencyStopError, Outcome
from beltsort.drivers.deadline import Deadline
from beltsort.drivers.ros.device import HEALTH_TIMEOUT, Received, RosDevice, emergency_stop
from beltsort.drivers.ros.keys import KeyStatus, Report
from beltsort.drivers.ros.ledger import Ledger
from beltsort.drivers.ros.link import MakeLink, Topics, publication
from beltsort.drivers.ros.options import SorterOptions
from beltsort.errors import CellError


class RosSorter(RosDevice):
    """A sorter on ROS.

    A sort must not be executed twice, so the sorter must remember keys: it executes a key once, and publishes
    its status. A key is the command id with the number of the attempt, "id/1" for example; a command that was
    rejected is sent again as the next attempt.

    Parameters
    ----------
    options
        Its topics.
    report
        The message with which it reports its keys.
    link
        Function that returns the link.
    """

    def __init__(self, options: SorterOptions, report: Report, link: MakeLink) -> None:
        topics = Topics(
            publish={options.command_topic: "diagnostic_msgs/KeyValue", options.stop_topic: "std_msgs/Empty"},
            subscribe={options.state_topic: report.kind, **emergency_stop(options)},
        )
        super().__init__(link("sorter", topics), options.state_topic, options.emergency_stop_topic)
        self._options, self._report = options, report
        self._ledger = Ledger()
        self._boot_ids: dict[str, str] = {}
        """Boot id of the sorter when each command was first sent."""

    def stop(self) -> None:
        """Command the sorter to stop."""
        self.connect()
        self._link.send(publication(self._options.stop_topic, {}), self._soon(HEALTH_TIMEOUT))

    def outcome_of(self, command_id: str, _boot_id: str = "", /) -> Outcome:
        """Return the outcome of a command, from the sorter's status if its end was not observed."""
        if command_id in self._ledger and self._ledger[command_id].outcome is not Outcome.UNKNOWN:
            return self._ledger[command_id].outcome
        try:
            self.connect()
            received = self._await(self._soon(HEALTH_TIMEOUT))
        except CellError:
            return Outcome.UNKNOWN
        statuses = self._statuses(received)
        attempts = takewhile(statuses.__contains__, (f"{command_id}/{number}" for number in count(1)))
        known = [statuses[key].outcome for key in attempts]
        return known[-1] if known else Outcome.UNKNOWN

    def sort(self, label: int, command_id: str, *, timeout: float = TIMEOUT) -> None:
        """Put the object at the belt end into bin number `label`.

        Raises
        ------
        CommandError
            If the sorter rejects it, cannot be reached, or does not report its end in time. A command whose
            outcome is unknown is not sent again to a sorter that was restarted.
        """
        unresolved = command_id in self._ledger and self._ledger[command_id].outcome is Outcome.UNKNOWN

        def act() -> float:
            return self._sort(label, command_id, timeout, unresolved)

        self._ledger.once("sort", label, command_id, act)

    def _sort(self, label: int, command_id: str, timeout: float, unresolved: bool) -> float:
        deadline = Deadline(timeout)
        try:
            key = self._begin(label, command_id, deadline, unresolved)
        except CommandError as failure:
            if unresolved:  # an earlier attempt may have been executed
                failure.outcome = Outcome.UNKNOWN
            raise
        return self._end(key, deadline, timeout)

    def _begin(self, label: int, command_id: str, deadline: Deadline, unresolved: bool) -> str:
        """Send a command if the sorter is ready; return its key."""
        self._link.connect(deadline.left())
        health = self.health()
        if not health.ready:
            kind = EmergencyStopError if health.emergency_stop else CommandError
            raise kind(f"the sorter takes no commands: {health.fault}", Outcome.NOT_DONE)
        if not unresolved:
            self._boot_ids.pop(command_id, None)
        if self._boot_ids.setdefault(command_id, health.boot_id) != health.boot_id:
            raise CommandError(
                f"command {command_id!r} was sent before the sorter was restarted and has forgotten it; "
                "check where the object is, and use a new id",
                Outcome.UNKNOWN,
            )
        key = _key(command_id, self._statuses(self._await(deadline)))
        message = {"key": key, "value": str(label)}
        self._link.send(publication(self._options.command_topic, message), deadline)
        return key

    def _end(self, key: str, deadline: Deadline, timeout: float) -> float:
        """Wait for the end of a command; return the time at which the sorter reported it, seconds."""
        number = 0
        while (received := self._await(deadline, number)) is not None:
            number = received.number
            status = self._statuses(received).get(key)
            if status is not None and status.outcome is Outcome.DONE:
                return received.stamp
            if status is not None and status.outcome is Outcome.NOT_DONE:
                raise CommandError(
                    f"the sorter refused {key!r}: {status.text}; resolve this and repeat", Outcome.NOT_DONE
                )
            if status is not None and status.outcome is Outcome.BROKEN_OFF:
                raise CommandError(
                    f"the sorter broke {key!r} off ({status.name}): {status.text}; check where the object is",
                    Outcome.BROKEN_OFF,
                )
            self._check_emergency_stop(deadline, Outcome.UNKNOWN)
        raise CommandError(
            f"the sorter reported no end of {key!r} on {self._topic} within {timeout:g} s; check it and "
            "ask for the outcome",
            Outcome.UNKNOWN,
        )

    def _statuses(self, received: Received | None) -> dict[str, KeyStatus]:
        """Return the status of each key that the sorter remembers."""
        return {} if received is None else self._report.statuses(received.message)


def _key(command_id: str, statuses: dict[str, KeyStatus]) -> str:
    """Return the key of the first attempt that was not rejected."""
    attempts = (f"{command_id}/{number}" for number in count(1))
    rejected = {key for key, status in statuses.items() if status.outcome is Outcome.NOT_DONE}
    return next(key for key in attempts if key not in rejected)
