"""The base class of the devices: a link to a node, and the topic on which the device publishes."""

import logging
from contextlib import suppress
from typing import Any, NamedTuple, Self

from beltsort.cell.commands import CommandError, EmergencyStopError, Outcome
from beltsort.cell.protocols import Health
from beltsort.drivers.deadline import Deadline
from beltsort.drivers.ros.frames import Frames
from beltsort.drivers.ros.link import Link
from beltsort.drivers.ros.options import ActuatorOptions
from beltsort.errors import CellError
from beltsort.geometry import Pose

log = logging.getLogger(__name__)

WAIT_SLICE = 0.25
"""Longest wait of one request to the node, seconds; at a deadline the error describes what arrived "
"instead."""

FIRST_MESSAGE = 2.0
"""Timeout of the first message from the device in `health`, seconds."""

HEALTH_TIMEOUT = 1.0
"""Timeout of the ROS system's reply in `health`, seconds."""


class Received(NamedTuple):
    """A received message, with the bytes of a point cloud.

    `stamp` is in seconds of this computer's monotonic clock, `ros_stamp` in ROS time as sent. `ahead` is the
    time in seconds by which the stamp is later than the arrival, which is 0 if clocks are synchronised.
    """

    number: int
    stamp: float
    ros_stamp: float
    ahead: float
    node: str
    message: dict[str, Any]
    data: bytes


class RosDevice:
    """A device behind a link.

    Parameters
    ----------
    link
        The link to beltsort's node.
    topic
        Topic on which the device publishes its state.
    emergency_stop_topic
        Topic of the state of the emergency stop; empty if there is none.
    """

    def __init__(self, link: Link, topic: str, emergency_stop_topic: str = "") -> None:
        self._link, self._topic = link, topic
        self._emergency_stop_topic = emergency_stop_topic
        self._node = ""
        self._last_health, self._ready_boot_id = Health(False, ""), ""

    @property
    def address(self) -> str:
        """The ROS system and the device's topic."""
        return f"{self._link.address}{self._topic}"

    def connect(self) -> None:
        """Start beltsort's node, if it does not run.

        Raises
        ------
        CommandError
            `NOT_DONE` if the ROS system does not answer, the node does not start, or a package is missing.
        """
        self._link.connect()

    def close(self) -> None:
        """End the node. A later call starts it again."""
        self._link.close()

    def __enter__(self) -> Self:
        """Use the device as a context that ends its node."""
        return self

    def __exit__(self, *_: object) -> None:
        """End the node."""
        self.close()

    def health(self) -> Health:
        """Return whether the device publishes and its node answers.

        The boot id changes when the ROS system or the device's node restarts.

        Raises
        ------
        CommandError
            `NOT_DONE` if the ROS system does not answer.
        """
        self.connect()
        system = self._link.identity(HEALTH_TIMEOUT)
        if not self._node:
            self._await(self._soon(FIRST_MESSAGE))
        if not self._node:
            fault = f"no message on {self._topic}; start its publisher"
            return self._noted(Health(False, system, fault))
        return self._health(*self._link.peer(self._topic, self._node))

    def _health(self, boot_id: str, fault: str) -> Health:
        """Return the state of a device that answers, unless there is a fault, with its emergency stop."""
        pressed = False
        if not fault:
            try:
                self._check_emergency_stop(self._soon(FIRST_MESSAGE), Outcome.NOT_DONE)
            except CommandError as reason:
                fault, pressed = str(reason), isinstance(reason, EmergencyStopError)
        return self._noted(Health(not fault, boot_id, fault, emergency_stop=pressed))

    def _noted(self, health: Health) -> Health:
        """Log what has changed since the last time, and return the state."""
        before, self._last_health = self._last_health, health
        if health.ready and self._ready_boot_id not in ("", health.boot_id):
            log.warning("%s was restarted", self.address)
        elif health.ready and not before.ready:
            log.info("%s is ready", self.address)
        if health.ready:
            self._ready_boot_id = health.boot_id
        if health.fault and health.fault != before.fault:
            log.warning("%s is not ready: %s", self.address, health.fault)
        return health

    def _check_emergency_stop(self, deadline: Deadline, outcome: Outcome) -> None:
        """Raise an error with this outcome if the emergency stop is pressed, or its state is unknown."""
        topic = self._emergency_stop_topic
        if not topic:
            return
        waiting = self._soon(FIRST_MESSAGE)
        message = self._link.newest(topic, deadline, wait=waiting.left()).values["message"]
        if message is None:
            raise CommandError(
                f"no message on {topic} within {waiting.timeout:.2g} s, expected the state of the emergency "
                "stop; start its publisher",
                outcome,
            )
        if message["data"]:
            raise EmergencyStopError(
                "the emergency stop is pressed; release it at the cell, once it is safe", outcome
            )

    def _await(
        self, deadline: Deadline, after: int = 0, not_before: float = 0.0, *, at_most: float = float("inf")
    ) -> Received | None:
        """Return a message with a number above `after`; None at the deadline, or after `at_most` seconds."""
        end = Deadline(min(at_most, deadline.left()))
        while True:
            wait = min(WAIT_SLICE, end.left())
            values, data = self._link.newest(
                self._topic, deadline, after=after, wait=wait, not_before=not_before
            )
            after = values["number"]
            if values["message"] is not None:
                self._node = values["node"]
                stamps = (values["stamp"], values["ros_stamp"], values["ahead"])
                return Received(after, *stamps, values["node"], values["message"], data)
            if end.left() == 0.0:
                return None

    def _soon(self, seconds: float) -> Deadline:
        """Return the end of a wait for an answer, which takes longer while nodes find each other."""
        return Deadline(seconds + self._link.discovery_left())

    def _current(self, deadline: Deadline) -> Received | None:
        """Return the next message, since the newest one may be from before a restart of the device."""
        newest = self._await(deadline, at_most=0.0)
        return self._await(deadline, newest.number if newest else 0)

    def _pose_in(self, world: str, frame: str, stamp: float, age: float, deadline: Deadline) -> Pose:
        """Return the pose of a frame from tf, shape (4, 4), not older than `age` seconds."""
        frames = Frames(age)
        answer = self._link.ask("transforms", WAIT_SLICE + deadline.left(), stamp=stamp)
        for transform in answer.values["transforms"]:
            with suppress(CellError):  # not rigid: an error only if the pose depends on it
                frames.add(*transform)
        return frames.pose(world, frame, stamp)


def emergency_stop(options: ActuatorOptions) -> dict[str, str]:
    """Return the subscription to the state of the emergency stop, if the options name its topic."""
    return {options.emergency_stop_topic: "std_msgs/Bool"} if options.emergency_stop_topic else {}
