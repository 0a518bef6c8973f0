"""The node program of a run, run by `beltsort.drivers.ros2.start` with a Python that has rclpy.

It imports the standard library, rclpy and the packages of the messages only, and ends when its socket is
closed.
"""

import os
import sys
import threading
from collections.abc import Mapping
from importlib import import_module
from multiprocessing.connection import Connection
from typing import Any

from beltsort.drivers.ros.serving import Reply, serve
from beltsort.drivers.ros2.messages import filled, interface_class

LEAVE_TIMEOUT = 1.0
"""Timeout of telling other nodes that this one leaves, seconds."""

ANSWER_TIMEOUT = 5.0
"""Timeout of the run's answer to a request, seconds."""

ACTIVATE, DEACTIVATE = "continue", "hold"
"""What each transition asks of the run."""


class Requests:
    """Requests of other nodes on their way to the process of the run, and its answers; one at a time."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._number = 0
        self._action = ""
        self._refusal: str | None = None
        """Why the last request was refused, empty if it was not; None until it is answered."""

    def ask(self, action: str) -> str:
        """Ask the run to hold or to continue; return why it refuses, empty if it does not."""
        with self._changed:
            self._number, self._action, self._refusal = self._number + 1, action, None
            self._changed.notify_all()
            self._changed.wait_for(lambda: self._refusal is not None, ANSWER_TIMEOUT)
            self._action = ""
            return "the run does not answer" if self._refusal is None else self._refusal

    def next(self, wait: float) -> tuple[int, str]:
        """Return number and action of a request; the action is empty if there is none within `wait` s."""
        with self._changed:
            self._changed.wait_for(lambda: self._action and self._refusal is None, wait)
            return self._number, self._action if self._refusal is None else ""

    def answer(self, number: int, refusal: str) -> None:
        """Answer a request; the answer to one that no longer waits is dropped."""
        with self._changed:
            if number == self._number:
                self._refusal = refusal
                self._changed.notify_all()


class Node:
    """The requests to the node: each public method handles one."""

    def __init__(self, setup: Mapping[str, Any]) -> None:
        self._lifecycle = import_module("rclpy.lifecycle")
        transitions = {
            "on_activate": lambda _node, _state: self._transition(ACTIVATE),
            "on_deactivate": lambda _node, _state: self._transition(DEACTIVATE),
        }
        kind = type("RunNode", (self._lifecycle.LifecycleNode,), transitions)
        self._node: Any = kind(setup["name"])
        self._requests, self._following = Requests(), False
        self._publishers = {
            topic: self._node.create_publisher(interface_class(message), topic, latched(kept))
            for topic, message, kept in setup["publish"]
        }
        describe = interface_class("rcl_interfaces/ParameterDescriptor")
        for name, value in setup["parameters"].items():
            self._node.declare_parameter(name, value, describe(read_only=True))
        self._executor = import_module("rclpy.executors").SingleThreadedExecutor()
        self._executor.add_node(self._node)
        self._node.trigger_configure()
        threading.Thread(target=self._executor.spin, daemon=True).start()

    def publish(self, topic: str, message: Mapping[str, Any]) -> Reply:
        """Publish a message."""
        publisher = self._publishers[topic]
        publisher.publish(filled(publisher.msg_type(), message))
        return {}, b""

    def follow(self, held: bool) -> Reply:
        """Make the node active or inactive, as the run is, without asking anything of it."""
        self._executor.create_task(self._follow, held)  # transitions belong to the executor's thread
        return {}, b""

    def next_request(self, wait: float) -> Reply:
        """Return number and action of a request of another node; the action is empty if there is none."""
        asked, action = self._requests.next(wait)
        return {"asked": asked, "action": action}, b""

    def answer(self, asked: int, refusal: str) -> Reply:
        """Answer a request by its number; `refusal` is empty if the run does what is asked."""
        self._requests.answer(asked, refusal)
        return {}, b""

    def leave(self) -> None:
        """Tell the other nodes that this one leaves."""
        self._node.destroy_node()

    def _follow(self, held: bool) -> None:
        state = self._node._state_machine.current_state[1]
        self._following = True
        try:
            if held and state == "active":
                self._node.trigger_deactivate()
            elif not held and state == "inactive":
                self._node.trigger_activate()
        finally:
            self._following = False

    def _transition(self, action: str) -> Any:
        results = self._lifecycle.TransitionCallbackReturn
        refusal = "" if self._following else self._requests.ask(action)
        if refusal:
            self._node.get_logger().warning(f"the run does not {action}: {refusal}")
        return results.FAILURE if refusal else results.SUCCESS


def latched(depth: int) -> Any:
    """Return the quality of service of topics whose last messages are kept for those that come later."""
    qos = import_module("rclpy.qos")
    durable = qos.DurabilityPolicy.TRANSIENT_LOCAL
    return qos.QoSProfile(depth=depth, reliability=qos.ReliabilityPolicy.RELIABLE, durability=durable)


RUNNING: list[Node] = []
"""The node, once it runs."""


def start(setup: dict[str, Any]) -> tuple[Node, dict[str, Any]]:
    """Start the node."""
    import_module("rclpy").init(args=[])
    node = Node(setup)
    RUNNING.append(node)
    return node, {}


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
