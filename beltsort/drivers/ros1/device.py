"""What the devices have in common: a node, and a topic by which the other side shows itself."""

import time
from typing import Any, NamedTuple, Self

import numpy as np

from beltsort.cell.commands import CommandError, EmergencyStopError, Outcome
from beltsort.cell.protocols import Health
from beltsort.drivers.ros1.link import GRACE, Deadline, Link
from beltsort.drivers.ros1.master import node_pid
from beltsort.drivers.ros1.options import Ros1ActuatorOptions
from beltsort.geometry import Pose

SLICE = 0.25
"""Seconds for which the node is asked to wait at a time, so that a deadline can say what came instead."""

LISTENERS = 0.05
"""Seconds between looks whether somebody listens."""

FIRST_MESSAGE = 2.0
"""Seconds within which `health` expects a message from the other side."""

HEALTH_TIMEOUT = 1.0
"""Seconds that master and node may each take to answer `health`."""


class News(NamedTuple):
    """A message, with the bytes of a point cloud.

    Its stamp is in seconds of this machine's monotonic clock, `ros_stamp` in ROS time as it was sent; `ahead`
    says by how many seconds it was later than its arrival, which no stamp should be.
    """

    number: int
    stamp: float
    ros_stamp: float
    ahead: float
    node: str
    message: dict[str, Any]
    data: bytes


class Ros1Device:
    """A device on the other side of a link.

    Parameters
    ----------
    link
        The way to our node.
    topic
        What the device publishes of itself.
    emergency_stop_topic
        Tells whether the emergency stop is pressed; empty: nothing does.
    """

    def __init__(self, link: Link, topic: str, *, emergency_stop_topic: str = "") -> None:
        self._link, self._topic = link, topic
        self._emergency_stop_topic = emergency_stop_topic
        self._node = ""

    @property
    def address(self) -> str:
        """The master and the topic of which the device tells."""
        return f"{self._link.master.uri}{self._topic}"

    def connect(self) -> None:
        """Start our node, if it does not run, and register with the master.

        Raises
        ------
        CommandError
            `NOT_DONE` if the master does not answer, our node does not start, or rospy is missing.
        """
        self._link.connect()

    def close(self) -> None:
        """End our node. A later call starts it again."""
        self._link.close()

    def __enter__(self) -> Self:
        """Use the device as a context that ends its node."""
        return self

    def __exit__(self, *_: object) -> None:
        """End our node."""
        self.close()

    def health(self) -> Health:
        """Say whether the other side publishes and answers.

        The boot id changes when the master or the other side restarts.

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
            return Health(False, master, f"nothing arrives on {self._topic}; start what publishes there")
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
        """Raise an error with this outcome if the emergency stop is pressed, or what should tell does not."""
        topic = self._emergency_stop_topic
        if not topic:
            return
        message = self._link.newest(topic, deadline, wait=FIRST_MESSAGE).values["message"]
        if message is None:
            raise CommandError(
                f"nothing on {topic} tells whether the emergency stop is pressed; start what publishes there",
                outcome,
            )
        if message["data"]:
            raise EmergencyStopError(
                "the emergency stop is pressed; release it at the cell, once it is safe", outcome
            )

    def _await(
        self, deadline: Deadline, after: int = 0, not_before: float = 0.0, *, at_most: float = float("inf")
    ) -> News | None:
        """Return a message of this device beyond number `after`; None at the deadline or `at_most` later."""
        end = Deadline(min(at_most, deadline.left()))
        while True:
            wait = min(SLICE, end.left())
            values, data = self._link.newest(
                self._topic, deadline, after=after, wait=wait, not_before=not_before
            )
            after = values["number"]
            if values["message"] is not None:
                self._node = values["node"]
                stamps = (values["stamp"], values["ros_stamp"], values["ahead"])
                return News(after, *stamps, values["node"], values["message"], data)
            if end.left() == 0.0:
                return None

    def _pose_in(self, world: str, frame: str, stamp: float, deadline: Deadline) -> Pose:
        """Return the pose of a frame as tf has it, shape (4, 4)."""
        asked = {"world": world, "camera": frame, "stamp": stamp}
        return np.array(self._link.ask("pose", SLICE + deadline.left(), **asked).values["pose"])

    def _publish(self, topic: str, message: dict[str, Any], deadline: Deadline) -> None:
        """Publish a message, waiting for somebody to listen.

        Raises
        ------
        CommandError
            `NOT_DONE` if nobody listens by the deadline.
        """
        while not self._post(topic, message, deadline):
            self._lie_in_wait(topic, deadline)

    def _lie_in_wait(self, topic: str, deadline: Deadline) -> None:
        """Let time pass until somebody may listen; raise a `CommandError` at the deadline."""
        if deadline.left() == 0.0:
            raise CommandError(
                f"nobody listens to {topic}, expected the device; start it, or mend the topic's name",
                Outcome.NOT_DONE,
            )
        time.sleep(min(LISTENERS, deadline.left()))

    def _post(self, topic: str, message: dict[str, Any], deadline: Deadline) -> bool:
        """Publish a message if anybody listens; return whether somebody does."""
        answer = self._link.ask("publish", deadline.left() + GRACE, topic=topic, message=message)
        return bool(answer.values["listeners"])


def emergency_stop(options: Ros1ActuatorOptions) -> dict[str, str]:
    """Return the subscription to the emergency stop's state, if there is one."""
    return {options.emergency_stop_topic: "std_msgs/Bool"} if options.emergency_stop_topic else {}
