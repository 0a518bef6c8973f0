"""A belt that is advanced by a service, one object at a call."""

from dataclasses import replace
from functools import partial

from beltsort.cell.commands import CommandError, Outcome
from beltsort.cell.protocols import Health
from beltsort.drivers.deadline import Deadline
from beltsort.drivers.ros.belt import ReportingBelt
from beltsort.drivers.ros.device import HEALTH_TIMEOUT, Received
from beltsort.drivers.ros2.link import Ros2Link
from beltsort.drivers.ros2.options import Ros2ServiceBeltOptions
from beltsort.drivers.ros2.trigger import Stopping, StopTopic, Trigger

POLL_INTERVAL = 0.05
"""Interval at which an answer is looked for, seconds."""

SETTLED = 1.0
"""Time for which the belt must stand before the first call of a process, seconds: an earlier process may have
called the service and not lived to see what came of it."""


class Ros2ServiceBelt(ReportingBelt):
    """A belt on ROS 2 that is advanced by a std_srvs/Trigger, by one object at a call.

    A call says neither which object is wanted nor which command it belongs to, so it is made only while the
    belt stands, and never again while an earlier one may still be carried out: until the call was answered,
    the belt has reported another object, or its node was restarted.

    Parameters
    ----------
    options
        Its services and topics.
    """

    def __init__(self, options: Ros2ServiceBeltOptions) -> None:
        self._advancing = Trigger(options.advance_service)
        self._stopping: Stopping = (
            Trigger(options.stop_service) if options.stop_service else StopTopic(options.stop_topic)
        )
        services = {**self._advancing.topics.services, **self._stopping.topics.services}
        topics = replace(self._stopping.topics, services=services)
        super().__init__(options, topics, partial(Ros2Link, options))
        self._called_at: Received | None = None
        """The belt's state before a call whose end was not observed."""
        self._settled = False

    def stop(self) -> None:
        """Command the belt to stop."""
        self.connect()
        deadline = self._soon(HEALTH_TIMEOUT)
        self._link.send(self._stopping.request(), deadline)
        self._stopping.confirm(self._link, deadline)

    def health(self) -> Health:
        """Return the belt's state; it is not ready while an earlier call may still be carried out."""
        health = super().health()
        if health.ready and self._called_at is not None:
            deadline = self._soon(HEALTH_TIMEOUT)
            state = self._current(deadline)
            if state is not None and (doubt := self._doubt(state, deadline)):
                return replace(health, ready=False, fault=doubt)
        return health

    def _bring(self, index: int, state: Received, deadline: Deadline) -> Received:
        while True:
            state = self._standing(state, deadline)
            at = state.message["data"]
            if at == index:
                return state
            if at > index:
                raise CommandError(
                    f"the belt has brought object {at} to its end, expected {index}; remove what it carried "
                    "too far",
                    Outcome.BROKEN_OFF,
                )
            if doubt := self._doubt(state, deadline):
                raise CommandError(doubt, Outcome.UNKNOWN)
            state = self._step(state, deadline)

    def _standing(self, state: Received, deadline: Deadline) -> Received:
        """Return the state of a belt that stands, before the first call for `SETTLED` seconds."""
        since = state
        while state.message["data"] < 0 or not (self._settled or state.stamp - since.stamp >= SETTLED):
            following = self._await(deadline, state.number)
            self._check_emergency_stop(deadline, Outcome.UNKNOWN)
            if following is None:
                raise CommandError(
                    f"the belt did not stand still within {deadline.timeout:g} s (it reported "
                    f"{state.message['data']} last), expected it to before it is advanced; check the belt",
                    Outcome.UNKNOWN,
                )
            if following.message["data"] != since.message["data"]:
                since = following
            state = following
        self._settled = True
        return state

    def _doubt(self, state: Received, deadline: Deadline) -> str:
        """Return why the belt may still carry out an earlier call; empty if it does not."""
        before = self._called_at
        if before is None:
            return ""
        moved = state.message["data"] != before.message["data"]
        answered = self._advancing.answer(self._link, deadline) is not None
        if state.node != before.node or (state.message["data"] >= 0 and (moved or answered)):
            self._called_at = None
            return ""
        return (
            f"the belt was told at object {before.message['data']} to advance by one, has not answered, and "
            f"may still do it; if it does not, start the node of {self._advancing.service} again"
        )

    def _step(self, state: Received, deadline: Deadline) -> Received:
        """Advance by one object; return the state once the belt stands at another one."""
        before = self._called_at = state
        try:
            self._link.send(self._advancing.request(), deadline)
        except CommandError as failure:
            if failure.outcome is Outcome.NOT_DONE:  # nothing was sent
                self._called_at = None
            raise
        while state.message["data"] in (before.message["data"], -1):
            self._check_emergency_stop(deadline, Outcome.UNKNOWN)
            answer = self._advancing.answer(self._link, deadline)
            if answer is not None and not answer.success:
                raise self._refused(before, answer.message, deadline)
            state = self._await(deadline, state.number, at_most=POLL_INTERVAL) or state
            if state.node != before.node:
                raise CommandError(
                    f"the node that reports the belt was restarted while the belt advanced from object "
                    f"{before.message['data']}; check which object is at its end",
                    Outcome.UNKNOWN,
                )
            if deadline.left() == 0.0:
                raise CommandError(
                    f"the belt was told at object {before.message['data']} to advance by one, and reported "
                    f"{state.message['data']} last, within {deadline.timeout:g} s; check the belt",
                    Outcome.UNKNOWN,
                )
        self._called_at = None
        return state

    def _refused(self, before: Received, why: str, deadline: Deadline) -> CommandError:
        """Return the error for a call that was answered by "no"."""
        after = self._current(deadline)
        stays = after is not None and after.message["data"] == before.message["data"]
        if stays:
            self._called_at = None
        return CommandError(
            f"{self._advancing.service} says that it failed: {why}; resolve this and repeat",
            Outcome.NOT_DONE if stays else Outcome.UNKNOWN,
        )
