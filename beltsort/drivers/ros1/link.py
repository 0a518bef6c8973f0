"""A link to a node in another process, with deadlines and restarts."""

from collections.abc import Iterable
from threading import RLock
from typing import Any
from uuid import uuid4

from beltsort.cell.commands import CommandError, Outcome
from beltsort.drivers.deadline import Deadline
from beltsort.drivers.ros1.master import Master
from beltsort.drivers.ros1.options import Ros1Options
from beltsort.drivers.ros1.process import Answer, NodeProcess

MASTER_TIMEOUT = 2.0
"""Timeout of the master's replies, seconds."""

START_TIMEOUT = 20.0
"""Timeout of the start of a node, seconds; it takes one on an idle computer."""

GRACE = 1.0
"""Time by which the node may miss a deadline before it is considered to hang, seconds."""


class Link:
    """A ROS 1 node, started when it is first needed and restarted after it or the master was restarted.

    Parameters
    ----------
    options
        Address of the ROS 1 system.
    role
        Part of the node's name.
    publish, subscribe
        Message type of each topic.
    joints
        Joint states without all of these joints are ignored.
    tf
        Whether to subscribe to tf.
    pose_age
        Largest difference between a requested time and that of a transform, seconds.
    """

    def __init__(
        self,
        options: Ros1Options,
        role: str,
        *,
        publish: dict[str, str] | None = None,
        subscribe: dict[str, str] | None = None,
        joints: Iterable[str] = (),
        tf: bool = False,
        pose_age: float = 0.2,
    ) -> None:
        self.master = Master(options.master)
        self._options, self._role = options, role
        topics = {"publish": publish or {}, "subscribe": subscribe or {}}
        self._setup = {**topics, "joints": sorted(joints), "tf": tf, "pose_age": pose_age}
        self._lock = RLock()
        self._process: NodeProcess | None = None

    def connect(self, timeout: float = START_TIMEOUT) -> None:
        """Start the node unless it runs and is registered with the master.

        Raises
        ------
        CommandError
            `NOT_DONE` if the master does not answer, the node does not start, or rospy is missing.
        """
        with self._lock:
            running, asking = self._process, min(MASTER_TIMEOUT, timeout)
            if running is None or not running.alive() or not self._known(running, asking):
                self.close()
                deadline = Deadline(timeout)
                self.master.identity(asking)  # rospy waits for a master without a timeout
                name = f"beltsort_{self._role}_{uuid4().hex[:8]}"
                self._process = NodeProcess(self._options, {**self._setup, "name": name}, deadline.left())

    def ask(self, request: str, timeout: float, **arguments: Any) -> Answer:
        """Send a request to the node, which must be connected, and return its answer.

        Raises
        ------
        CommandError
            `UNKNOWN` if it does not answer in time, or has ended.
        CellError
            If the request fails, with the node's message.
        """
        process = self._process
        if process is None:
            raise CommandError(
                f"the ROS node {self._role!r} is not connected; call connect()", Outcome.NOT_DONE
            )
        return process.ask(request, timeout, **arguments)

    def newest(
        self, topic: str, deadline: Deadline, *, after: int = 0, wait: float = 0.0, not_before: float = 0.0
    ) -> Answer:
        """Return the newest message of `topic` with a number above `after`.

        "message" is None if there is none within `wait` seconds, or by the deadline. The bytes of a message
        with a stamp earlier than `not_before` are omitted.
        """
        left = deadline.left()
        asked = {"topic": topic, "after": after, "wait": min(wait, left), "not_before": not_before}
        return self.ask("newest", left + GRACE, **asked)

    def close(self) -> None:
        """End the node."""
        with self._lock:
            if self._process is not None:
                self._process.end()
                self._process = None

    def _known(self, process: NodeProcess, timeout: float) -> bool:
        return self.master.node_uri(f"/{process.name}", timeout) == process.uri
