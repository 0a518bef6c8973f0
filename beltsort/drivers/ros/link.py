"""A link to a node in another process, with deadlines and restarts."""

import logging
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from threading import RLock
from typing import Any, NamedTuple, TypeAlias
from uuid import uuid4

from beltsort.cell.commands import CommandError, Outcome
from beltsort.drivers.deadline import Deadline
from beltsort.drivers.ros.process import Answer, NodeProcess

log = logging.getLogger(__name__)

START_TIMEOUT = 20.0
"""Timeout of the start of a node, seconds; it takes one on an idle computer."""

GRACE = 1.0
"""Time by which the node may miss a deadline before it is considered to hang, seconds."""

SUBSCRIBER_INTERVAL = 0.05
"""Interval at which the number of subscribers is polled, seconds."""


class Outgoing(NamedTuple):
    """A request to the node that sends something: the topic or action it goes to, its name and arguments."""

    to: str
    request: str
    arguments: Mapping[str, object]


def publication(topic: str, message: Mapping[str, object]) -> Outgoing:
    """Return the request to publish a message."""
    return Outgoing(topic, "publish", {"topic": topic, "message": message})


@dataclass(frozen=True, kw_only=True)
class Topics:
    """What a node publishes and subscribes to.

    Attributes
    ----------
    publish, subscribe
        Message type of each topic, as "std_msgs/Int32".
    actions
        Type of each action, as "control_msgs/FollowJointTrajectory", by its namespace; ROS 2 only.
    services
        Type of each service that is called, as "std_srvs/Trigger"; ROS 2 only.
    joints
        Joint states without all of these joints are ignored.
    tf
        Whether to subscribe to tf.
    """

    publish: Mapping[str, str] = field(default_factory=dict)
    subscribe: Mapping[str, str] = field(default_factory=dict)
    actions: Mapping[str, str] = field(default_factory=dict)
    services: Mapping[str, str] = field(default_factory=dict)
    joints: Iterable[str] = ()
    tf: bool = False

    def setup(self, name: str) -> dict[str, Any]:
        """Return the setup of a node of this name."""
        topics = {
            "publish": dict(self.publish),
            "subscribe": dict(self.subscribe),
            "actions": dict(self.actions),
            "services": dict(self.services),
        }
        return {"name": name, **topics, "joints": sorted(self.joints), "tf": self.tf}


class Link(ABC):
    """A node in another process, started when it is first needed, and again after it has ended.

    Parameters
    ----------
    role
        Part of the node's name.
    topics
        Its topics.

    Attributes
    ----------
    discovery
        Time that nodes may take to find each other, seconds.
    """

    discovery = 0.0

    def __init__(self, role: str, topics: Topics) -> None:
        self._role, self._topics = role, topics
        self._lock = RLock()
        self._process: NodeProcess | None = None
        self._discovered = Deadline(0.0)

    @property
    @abstractmethod
    def address(self) -> str:
        """The ROS system."""

    @abstractmethod
    def identity(self, timeout: float) -> str:
        """Return an identity of the ROS system that changes when it restarts; empty if it has none.

        Raises
        ------
        CommandError
            `NOT_DONE` if it does not answer.
        """

    @abstractmethod
    def peer(self, topic: str, node: str, /) -> tuple[str, str]:
        """Return the boot id of the node that publishes on a topic, and why it does not answer, if so.

        Raises
        ------
        CommandError
            `NOT_DONE` if the ROS system does not answer.
        """

    @abstractmethod
    def _usable(self, process: NodeProcess, timeout: float) -> bool:
        """Return whether the ROS system still knows a running node."""

    @abstractmethod
    def _start(self, setup: dict[str, Any], deadline: Deadline) -> NodeProcess:
        """Start a node."""

    def connect(self, timeout: float = START_TIMEOUT) -> None:
        """Start the node unless it runs and is known to the ROS system.

        Raises
        ------
        CommandError
            `NOT_DONE` if the ROS system does not answer, the node does not start, or a package is missing.
        """
        with self._lock:
            if (running := self._process) is not None:
                if running.alive() and self._usable(running, timeout):
                    return
                why = "the ROS system does not know it" if running.alive() else "its process ended"
                log.warning("lost the ROS node %s (%s); starting another one", running.name, why)
            self.close()
            name = f"beltsort_{self._role}_{uuid4().hex[:8]}"
            self._process = self._start(self._topics.setup(name), Deadline(timeout))
            self._discovered = Deadline(self.discovery)
            log.info("started the ROS node %s, process %d", name, self._process.process_id)

    def discovery_left(self) -> float:
        """Return the seconds that nodes may still take to find this one."""
        return self._discovered.left()

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

    def send(self, outgoing: Outgoing, deadline: Deadline) -> None:
        """Send a message, waiting for a subscriber.

        Raises
        ------
        CommandError
            `NOT_DONE` if there is no subscriber by the deadline.
        """
        while not self.send_once(outgoing, deadline):
            self.wait_for_subscriber(outgoing.to, deadline)

    def send_once(self, outgoing: Outgoing, deadline: Deadline) -> bool:
        """Send a message if it has a subscriber; return whether it has."""
        answer = self.ask(outgoing.request, deadline.left() + GRACE, **outgoing.arguments)
        return bool(answer.values["listeners"])

    def wait_for_subscriber(self, topic: str, deadline: Deadline) -> None:
        """Sleep until the next poll for a subscriber; raise a `CommandError` at the deadline."""
        if deadline.left() == 0.0:
            raise CommandError(
                f"{topic} has no subscriber, expected the device; start it, or correct the topic's name",
                Outcome.NOT_DONE,
            )
        time.sleep(min(SUBSCRIBER_INTERVAL, deadline.left()))

    def close(self) -> None:
        """End the node."""
        with self._lock:
            if self._process is not None:
                self._process.end()
                log.info("ended the ROS node %s", self._process.name)
                self._process = None


MakeLink: TypeAlias = Callable[[str, Topics], Link]
"""Function of a role and topics that returns a link."""
