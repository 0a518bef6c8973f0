"""The ROS 2 node, run by `start.py` with a Python that has rclpy and the packages of the messages.

It ends when its socket is closed.
"""

import os
import sys
import threading
import time
from collections.abc import Iterable
from importlib import import_module
from multiprocessing.connection import Connection
from typing import Any

from beltsort.drivers.ros.serving import (
    JOINT_STATE,
    QUEUE,
    SCANS,
    Mailbox,
    Reply,
    Transforms,
    answered,
    serve,
)
from beltsort.drivers.ros2.actions import Action
from beltsort.drivers.ros2.messages import filled, interface_class
from beltsort.drivers.ros2.services import Service, request_topic

LEAVE_TIMEOUT = 1.0
"""Timeout of telling other nodes that this one leaves, seconds."""

UNKNOWN, NAMING = "_UNKNOWN_", 0.5
"""Part of the name of a node that is not known yet, and the time for which it is waited for, seconds."""

LOOK_INTERVAL = 0.2
"""Interval at which publishers are looked at until a subscription fits them best, seconds."""

TF = "tf2_msgs/TFMessage"
LATCHED = ("std_msgs/Bool", "sensor_msgs/CameraInfo")
"""Types that some publish once and keep for those that come later, and others repeat."""
KEPT = ("action_msgs/msg/GoalStatusArray", "std_msgs/Int64MultiArray")
"""Types that are always kept for those that come later."""


class Node:
    """The requests to the node: each public method handles one."""

    def __init__(self, rclpy: Any, setup: dict[str, Any]) -> None:
        self._node = rclpy.create_node(setup["name"], enable_rosout=False, start_parameter_services=False)
        executor = import_module("rclpy.executors").SingleThreadedExecutor()
        executor.add_node(self._node)
        self._transforms, self._discovered = Transforms(), Discovered()
        self._publishers = {
            topic: self._node.create_publisher(interface_class(kind), topic, 10)
            for topic, kind in setup["publish"].items()
        }
        joints = setup["joints"]
        self._mailboxes: dict[str, Mailbox] = {}
        for topic, kind in setup["subscribe"].items():
            self._mailboxes[topic] = Mailbox(self._clock, joints if kind == JOINT_STATE else ())
            self._subscribe(topic, kind, self._mailboxes[topic])
        self._actions: dict[str, Action] = {}
        for name, kind in setup["actions"].items():
            self._mailboxes[f"{name}/result"] = Mailbox(self._clock)
            self._actions[name] = Action(self._node, executor, name, kind, self._mailboxes[f"{name}/result"])
        self._services: dict[str, Service] = {}
        for name, kind in setup["services"].items():
            answers = self._mailboxes[f"{name}/answer"] = Mailbox(self._clock)
            self._services[name] = Service(self._node, executor, name, kind, answers)
        if setup["tf"]:
            self._listen("/tf", TF, profile(QUEUE), lambda m, _: self._transforms.add(m, static=False))
            kept = profile(QUEUE, durable=True)
            self._listen("/tf_static", TF, kept, lambda m, _: self._transforms.add(m, static=True))
        threading.Thread(target=executor.spin, daemon=True).start()

    def newest(self, topic: str, after: int, wait: float, not_before: float) -> Reply:
        """Return the newest message with a number above `after`, and its bytes if it is not stale."""
        arrived = self._mailboxes[topic].newest(after, wait)
        if arrived.message is not None and not arrived.sender:
            arrived = arrived._replace(sender=self._discovered.last(topic, self._gids(topic)))
        return answered(arrived, not_before)

    def publish(self, topic: str, message: dict[str, Any]) -> Reply:
        """Publish a message if there are subscribers; return their number."""
        publisher = self._publishers[topic]
        listeners = publisher.get_subscription_count()
        if listeners:
            publisher.publish(filled(publisher.msg_type(), message))
        return {"listeners": listeners}, b""

    def send_goal(self, action: str, goal_id: str, goal: dict[str, Any]) -> Reply:
        """Send a goal if the action has a server; return whether it has."""
        return {"listeners": int(self._actions[action].send(goal_id, goal))}, b""

    def cancel_goals(self, action: str) -> Reply:
        """Request that all goals of an action are cancelled, if it has a server; return whether it has."""
        return {"listeners": int(self._actions[action].cancel())}, b""

    def call(self, service: str, call_id: str) -> Reply:
        """Call a service once, if it has a server; return whether it has."""
        return {"listeners": int(self._services[service].call(call_id))}, b""

    def server(self, service: str) -> Reply:
        """Return the identity of the server that was discovered last; empty if there is none.

        A middleware that is not of DDS tells no identities; it is "unknown" then.
        """
        topic = request_topic(service)
        found = self._node.get_subscriptions_info_by_topic(topic, no_mangle=True)
        last = self._discovered.last(topic, [bytes(each.endpoint_gid).hex() for each in found])
        return {"identity": last or ("unknown" if self._services[service].ready() else "")}, b""

    def publishers(self, topic: str) -> Reply:
        """Return the names of the nodes that publish on a topic by the identity of the publisher.

        Waits a moment, since names are discovered after publishers.
        """
        end = time.monotonic() + NAMING
        while True:
            found = self._node.get_publishers_info_by_topic(topic)
            named = {
                bytes(each.endpoint_gid).hex(): f"{each.node_namespace.rstrip('/')}/{each.node_name}"
                for each in found
                if UNKNOWN not in each.node_name
            }
            if len(named) == len(found) or time.monotonic() > end:
                return {"names": named}, b""
            time.sleep(LOOK_INTERVAL)

    def transforms(self, stamp: float) -> Reply:
        """Return the transforms of tf nearest to a time."""
        return {"transforms": self._transforms.nearest(stamp)}, b""

    def leave(self) -> None:
        """Tell the other nodes that this one leaves."""
        self._node.destroy_node()

    def _clock(self) -> float:
        return float(self._node.get_clock().now().nanoseconds * 1e-9)

    def _gids(self, topic: str) -> list[str]:
        found = self._node.get_publishers_info_by_topic(topic)
        return [bytes(endpoint.endpoint_gid).hex() for endpoint in found]

    def _subscribe(self, topic: str, kind: str, mailbox: Mailbox) -> None:
        """Subscribe to a topic, whatever the publisher's reliability and durability."""

        def receive(message: Any, info: Any) -> None:
            mailbox.put(message, gid_of(info))

        if kind in KEPT:
            self._listen(topic, kind, profile(QUEUE, durable=True), receive)
            return
        first = self._listen(topic, kind, profile(1 if kind in SCANS else QUEUE), receive)
        if kind in LATCHED + SCANS:
            self._adapt(topic, kind, receive, first)

    def _adapt(self, topic: str, kind: str, receive: Any, first: Any) -> None:
        """Subscribe anew to a publisher that keeps messages or, of scans, repeats what was lost of them.

        A subscription that a publisher does not fit is not tried, since both sides would warn of it.
        """
        qos = import_module("rclpy.qos")
        kept, repeated = qos.DurabilityPolicy.TRANSIENT_LOCAL, qos.ReliabilityPolicy.RELIABLE

        def look() -> None:
            found = [each.qos_profile for each in self._node.get_publishers_info_by_topic(topic)]
            durable = any(each.durability == kept for each in found)
            reliable = bool(found) and all(each.reliability == repeated for each in found)
            if kind in LATCHED and durable:
                timer.cancel()
                self._listen(topic, kind, profile(QUEUE, durable=True), receive)
            elif kind in SCANS and reliable:
                timer.cancel()
                self._listen(topic, kind, profile(1, reliable=True), receive)
                self._node.destroy_subscription(first)

        timer = self._node.create_timer(LOOK_INTERVAL, look)

    def _listen(self, topic: str, kind: str, quality: Any, receive: Any) -> Any:
        """Subscribe; rclpy chooses by the number of parameters whether a callback is given the sender."""
        informed = hasattr(import_module("rclpy.subscription"), "MessageInfo")  # not yet in Humble
        callback = receive if informed else lambda message: receive(message, {})
        return self._node.create_subscription(interface_class(kind), topic, callback, quality)


class Discovered:
    """The publishers of topics in the order of their discovery.

    The rclpy of Jazzy and before does not report a message's sender. A publisher that was killed is known for
    another 20 s, so the one that was discovered last is taken for it.

    Examples
    --------
    >>> discovered = Discovered()
    >>> [discovered.last("/belt/object", known) for known in (["a"], ["b", "a"], ["a", "b"], ["b"], [])]
    ['a', 'b', 'b', 'b', '']
    """

    def __init__(self) -> None:
        self._known: dict[str, list[str]] = {}

    def last(self, topic: str, gids: Iterable[str]) -> str:
        """Return the publisher that was discovered last of those that are known now."""
        now = sorted(gids)
        before = [gid for gid in self._known.get(topic, []) if gid in now]
        self._known[topic] = [*before, *(gid for gid in now if gid not in before)]
        return self._known[topic][-1] if now else ""


def gid_of(info: Any) -> str:
    """Return the identity of a message's publisher; empty if rclpy does not report it."""
    gid = info.get("publisher_gid")
    return bytes(gid["data"]).hex() if gid else ""


def profile(depth: int, *, reliable: bool = False, durable: bool = False) -> Any:
    """Return the quality of service of a subscription.

    Best effort fits publishers that are best effort or reliable, but large messages may be lost; durable ones
    are reliable, and keep messages for those that come later.
    """
    qos = import_module("rclpy.qos")
    reliability, durability = qos.ReliabilityPolicy, qos.DurabilityPolicy
    return qos.QoSProfile(
        depth=depth,
        reliability=reliability.RELIABLE if reliable or durable else reliability.BEST_EFFORT,
        durability=durability.TRANSIENT_LOCAL if durable else durability.VOLATILE,
    )


def start(setup: dict[str, Any]) -> tuple[Node, dict[str, Any]]:
    """Start a node."""
    rclpy = import_module("rclpy")
    rclpy.init(args=[])
    node = Node(rclpy, setup)
    RUNNING.append(node)
    return node, {}


RUNNING: list[Node] = []
"""The node, once it runs."""


def main() -> None:
    """Serve, then leave within a timeout."""
    try:
        serve(Connection(int(sys.argv[-1])), start)
    except (EOFError, OSError):
        for node in RUNNING:
            leaving = threading.Thread(target=node.leave, daemon=True)
            leaving.start()
            leaving.join(LEAVE_TIMEOUT)
    os._exit(0)  # rclpy's threads may block without a timeout
