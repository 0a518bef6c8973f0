"""The base class of the devices: a link to a node, and the topic on which the device publishes."""

import time
from typing import Any, NamedTuple, Self

import numpy as np

from beltsort.cell.commands import CommandError, EmergencyStopError, Outcome
from beltsort.cell.protocols import Health
from beltsort.drivers.deadline import Deadline
from beltsort.drivers.ros1.link import GRACE, Link
from beltsort.drivers.ros1.master import node_pid
from beltsort.drivers.ros1.options import Ros1ActuatorOptions
from beltsort.geometry import Pose

WAIT_SLICE = 0.25
"""Longest wait of one request to the node, seconds; at a deadline the error describes what arrived "
"instead."""

SUBSCRIBER_INTERVAL = 0.05
"""Interval at which the number of subscribers is polled, seconds."""

FIRST_MESSAGE = 2.0
"""Timeout of the first message from the device in `health`, seconds."""

HEALTH_TIMEOUT = 1.0
"""Timeout of the master's and the node's replies in `health`, seconds each."""


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


class Ros1Device:
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

    def __init__(self, link: Link, topic: str, *, emergency_stop_topic: str = "") -> None:
        self._link, self._topic = link, topic
        self._emergency_stop_topic = emergency_stop_topic
        self._node = ""

    @property
    def address(self) -> str:
        """The master's URI and the device's topic."""
        return f"{self._link.master.uri}{self._topic}"

    def connect(self) -> None:
        """Start beltsort's node, if it does not run, and register it with the master.

        Raises
        ------
        CommandError
            `NOT_DONE` if the master does not answer, the node does not start, or rospy is missing.
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

        The boot id changes when the master or the device's node restarts.

        Raises
        ------
        CommandError
            `NOT_DONE` if the master does not answer.
        """
        self.connect()
        master = self._link.master.identity(HEALTH_TIMEOUT)
        if not self._node:
            self._await(Deadline(FIRST_MESSAGE))
        if not self._node:
            return Health(False, master, f"no message on {self._topic}; start its publisher")
        uri = self._link.master.node_uri(self._node, HEALTH_TIMEOUT)
        if uri is None:
            return Health(False, master, f"the node {self._node} has left the master; start it again")
        boot_id = f"{master} {uri}"
        try:
            boot_id += f" {node_pid(self._node, uri, HEALTH_TIMEOUT)}"
            self._check_emergency_stop(Deadline(FIRST_MESSAGE), Outcome.NOT_DONE)
        except CommandError as reason:
            pressed = isinstance(reason, EmergencyStopError)
            return Health(False, boot_id, str(reason), emergency_stop=pressed)
        return Health(True, boot_id)

    def _check_emergency_stop(self, deadline: Deadline, outcome: Outcome) -> None:
        """Raise an error with this outcome if the emergency stop is pressed, or its state is unknown."""
        topic = self._emergency_stop_topic
        if not topic:
            return
        message = self._link.newest(topic, deadline, wait=FIRST_MESSAGE).values["message"]
        if message is None:
            raise CommandError(
                f"no message on {topic} within {FIRST_MESSAGE:g} s, expected the state of the emergency "
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

    def _pose_in(self, world: str, frame: str, stamp: float, deadline: Deadline) -> Pose:
        """Return the pose of a frame from tf, shape (4, 4)."""
        asked = {"world": world, "camera": frame, "stamp": stamp}
        return np.array(self._link.ask("pose", WAIT_SLICE + deadline.left(), **asked).values["pose"])

    def _publish(self, topic: str, message: dict[str, Any], deadline: Deadline) -> None:
        """Publish a message, waiting for a subscriber.

        Raises
        ------
        CommandError
            `NOT_DONE` if there is no subscriber by the deadline.
        """
        while not self._publish_once(topic, message, deadline):
            self._wait_for_subscriber(topic, deadline)

    def _wait_for_subscriber(self, topic: str, deadline: Deadline) -> None:
        """Sleep until the next poll for a subscriber; raise a `CommandError` at the deadline."""
        if deadline.left() == 0.0:
            raise CommandError(
                f"{topic} has no subscriber, expected the device; start it, or correct the topic's name",
                Outcome.NOT_DONE,
            )
        time.sleep(min(SUBSCRIBER_INTERVAL, deadline.left()))

    def _publish_once(self, topic: str, message: dict[str, Any], deadline: Deadline) -> bool:
        """Publish a message if the topic has a subscriber; return whether it has."""
        answer = self._link.ask("publish", deadline.left() + GRACE, topic=topic, message=message)
        return bool(answer.values["listeners"])


def emergency_stop(options: Ros1ActuatorOptions) -> dict[str, str]:
    """Return the subscription to the state of the emergency stop, if the options name its topic."""
    return {options.emergency_stop_topic: "std_msgs/Bool"} if options.emergency_stop_topic else {}
