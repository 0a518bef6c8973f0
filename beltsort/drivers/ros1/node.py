"""A ROS 1 node in a process of its own: `python -m beltsort.drivers.ros1.node FD`.

rospy can be initialised only once per process. The node ends when the socket is closed.
"""

import os
import sys
import threading
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
from beltsort.drivers.ros1.messages import message_class

UNREGISTER_TIMEOUT = 1.0
"""Timeout of unregistering from the master, seconds."""

RECEIVE_BUFFER = 2**25
"""Size of the receive buffer, bytes; rospy drops old messages only if a complete one fits into it."""


class Node:
    """The requests to the node: each public method handles one."""

    def __init__(self, rospy: Any, setup: dict[str, Any]) -> None:
        self._rospy = rospy
        self._transforms = Transforms()
        rospy.init_node(setup["name"], disable_signals=True, disable_rosout=True)
        self._publishers = {
            topic: rospy.Publisher(topic, message_class(kind), queue_size=10, tcp_nodelay=True)
            for topic, kind in setup["publish"].items()
        }
        self._joints = setup["joints"]
        self._mailboxes = {topic: self._subscribed(topic, kind) for topic, kind in setup["subscribe"].items()}
        if setup["tf"]:
            kind, add = message_class("tf2_msgs/TFMessage"), self._transforms.add
            rospy.Subscriber("/tf", kind, lambda message: add(message, static=False), queue_size=QUEUE)
            rospy.Subscriber("/tf_static", kind, lambda message: add(message, static=True), queue_size=QUEUE)

    def newest(self, topic: str, after: int, wait: float, not_before: float) -> Reply:
        """Return the newest message with a number above `after`, and its bytes if it is not stale."""
        return answered(self._mailboxes[topic].newest(after, wait), not_before)

    def publish(self, topic: str, message: dict[str, Any]) -> Reply:
        """Publish a message if there are subscribers; return their number."""
        publisher = self._publishers[topic]
        listeners = publisher.get_num_connections()
        if listeners:
            made = publisher.data_class()
            import_module("genpy").message.fill_message_args(made, [message])
            publisher.publish(made)
        return {"listeners": listeners}, b""

    def transforms(self, stamp: float) -> Reply:
        """Return the transforms of tf nearest to a time."""
        return {"transforms": self._transforms.nearest(stamp)}, b""

    def _subscribed(self, topic: str, kind: str) -> Mailbox:
        mailbox = Mailbox(self._rospy.get_time, self._joints if kind == JOINT_STATE else ())
        self._rospy.Subscriber(
            topic,
            message_class(kind),
            lambda message: mailbox.put(message, message._connection_header["callerid"]),
            queue_size=1 if kind in SCANS else QUEUE,
            buff_size=RECEIVE_BUFFER,
            tcp_nodelay=True,
        )
        return mailbox


def start(setup: dict[str, Any]) -> tuple[Node, dict[str, Any]]:
    """Register a node with the master; return it and its URI."""
    rospy = import_module("rospy")
    return Node(rospy, setup), {"uri": rospy.get_node_uri()}


def main() -> None:
    """Serve, then unregister from the master within a timeout."""
    try:
        serve(Connection(int(sys.argv[1])), start)
    except (EOFError, OSError):
        rospy = sys.modules.get("rospy")
        if rospy is not None:
            leaving = threading.Thread(target=rospy.signal_shutdown, args=("done",), daemon=True)
            leaving.start()
            leaving.join(UNREGISTER_TIMEOUT)
    os._exit(0)  # rospy's threads may block without a timeout


if __name__ == "__main__":
    main()
