"""A ROS 1 node in a process of its own: `python -m beltsort.drivers.ros1.node FD`.

rospy can be initialised only once per process, and some of its calls block without a timeout; a process of
its own can be killed. Requests are JSON over a socket, answers are JSON and, for point clouds, bytes. The
node ends when the socket is closed.
"""

import json
import os
import sys
import threading
import time
from collections.abc import Callable
from importlib import import_module
from multiprocessing.connection import Connection
from typing import Any, NamedTuple

from beltsort.drivers.ros.frames import Frames
from beltsort.drivers.ros1.messages import message_class
from beltsort.errors import CellError

UNREGISTER_TIMEOUT = 1.0
"""Timeout of unregistering from the master, seconds."""

RECEIVE_BUFFER = 2**25
"""Size of the receive buffer, bytes; rospy drops old messages only if a complete one fits into it."""

JOINT_STATE, CLOUD = "sensor_msgs/JointState", "sensor_msgs/PointCloud2"
QUEUE = 100
"""Queue size of topics other than clouds, of which only the newest is kept."""


class Mailbox:
    """The newest message of a topic; of joint states, the newest that contains the given joints."""

    def __init__(self, rospy: Any, topic: str, kind: str, joints: set[str]) -> None:
        self._clock: Callable[[], float] = rospy.get_time
        self._joints = joints if kind == JOINT_STATE else set()
        self._arrival = threading.Condition()
        self._newest: Arrived = Arrived(0, 0.0, 0.0, None)
        rospy.Subscriber(
            topic,
            message_class(kind),
            self._receive,
            queue_size=1 if kind == CLOUD else QUEUE,
            buff_size=RECEIVE_BUFFER,
            tcp_nodelay=True,
        )

    def _receive(self, message: Any) -> None:
        if self._joints and not self._joints <= set(message.name):
            return  # joint states of another part of the robot
        with self._arrival:
            self._newest = Arrived(self._newest.number + 1, time.monotonic(), self._clock(), message)
            self._arrival.notify_all()

    def newest(self, after: int, wait: float) -> "Arrived":
        """Return the newest message if its number is above `after`.

        Waits for it for `wait` seconds; the content is None if there is none.
        """
        with self._arrival:
            self._arrival.wait_for(lambda: self._newest.number > after, wait)
            return self._newest if self._newest.number > after else Arrived(after, 0.0, 0.0, None)


class Arrived(NamedTuple):
    """A message: its number, its arrival on the monotonic clock and in ROS time, and its content."""

    number: int
    at: float
    ros_time: float
    message: Any

    @property
    def stamp(self) -> float:
        """Stamp in ROS time; the time of arrival if it has none."""
        header = getattr(self.message, "header", None)
        return (0.0 if header is None else float(header.stamp.to_sec())) or self.ros_time

    @property
    def age(self) -> float:
        """Time from stamp to arrival, seconds; negative if clocks are not synchronised."""
        return self.ros_time - self.stamp


class Node:
    """The requests to the node: each public method handles one."""

    def __init__(self, rospy: Any, setup: dict[str, Any]) -> None:
        self._rospy = rospy
        self._frames, self._lock = Frames(setup["pose_age"]), threading.Lock()
        rospy.init_node(setup["name"], disable_signals=True, disable_rosout=True)
        self._publishers = {
            topic: rospy.Publisher(topic, message_class(kind), queue_size=10, tcp_nodelay=True)
            for topic, kind in setup["publish"].items()
        }
        joints = set(setup["joints"])
        self._mailboxes = {
            topic: Mailbox(rospy, topic, kind, joints) for topic, kind in setup["subscribe"].items()
        }
        if setup["tf"]:
            transforms = message_class("tf2_msgs/TFMessage")
            rospy.Subscriber("/tf", transforms, self._moved, queue_size=QUEUE)
            rospy.Subscriber("/tf_static", transforms, self._fixed, queue_size=QUEUE)

    def newest(self, topic: str, after: int, wait: float, not_before: float) -> tuple[dict[str, Any], bytes]:
        """Return the newest message with a number above `after`, and its bytes if it is not stale."""
        return answered(self._mailboxes[topic].newest(after, wait), not_before)

    def publish(self, topic: str, message: dict[str, Any]) -> tuple[dict[str, Any], bytes]:
        """Publish a message if there are subscribers; return their number."""
        publisher = self._publishers[topic]
        listeners = publisher.get_num_connections()
        if listeners:
            made = publisher.data_class()
            import_module("genpy").message.fill_message_args(made, [message])
            publisher.publish(made)
        return {"listeners": listeners}, b""

    def pose(self, world: str, camera: str, stamp: float) -> tuple[dict[str, Any], bytes]:
        """Return `world_from_camera` from tf."""
        with self._lock:
            return {"pose": self._frames.pose(world, camera, stamp).tolist()}, b""

    def _moved(self, message: Any) -> None:
        for each in message.transforms:
            self._add(each, each.header.stamp.to_sec())

    def _fixed(self, message: Any) -> None:
        for each in message.transforms:
            self._add(each, None)

    def _add(self, transform: Any, stamp: float | None) -> None:
        t, q = transform.transform.translation, transform.transform.rotation
        parent, child = transform.header.frame_id, transform.child_frame_id
        with self._lock:
            self._frames.add(parent, child, stamp, [t.x, t.y, t.z], [q.x, q.y, q.z, q.w])


def answered(arrived: Arrived, not_before: float) -> tuple[dict[str, Any], bytes]:
    """Return the answer for a message, and its bytes if it is not stale.

    "stamp" is converted to the monotonic clock by the message's age at arrival, so that setting a clock does
    not change the order of events.
    """
    message = arrived.message
    if message is None:
        return {"number": arrived.number, "message": None}, b""
    answer = {
        "number": arrived.number,
        "stamp": arrived.at - max(0.0, arrived.age),
        "ros_stamp": arrived.stamp,
        "ahead": max(0.0, -arrived.age),
        "node": message._connection_header["callerid"],
        "message": plain(message),
    }
    data = getattr(message, "data", b"")
    fresh = isinstance(data, bytes) and answer["stamp"] >= not_before
    return answer, data if fresh else b""


def plain(value: Any) -> Any:
    """Return a message as dictionaries, lists and numbers, without its bytes."""
    if hasattr(value, "to_sec"):
        return value.to_sec()
    if hasattr(value, "__slots__"):
        return {name: plain(getattr(value, name)) for name in value.__slots__}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    return None if isinstance(value, bytes) else value


def serve(connection: Connection) -> None:
    """Answer requests until the socket closes."""
    sending = threading.Lock()

    def send(answer: dict[str, Any], data: bytes = b"") -> None:
        with sending:
            connection.send_bytes(json.dumps(answer).encode())
            connection.send_bytes(data)

    def act(number: int, name: str, **arguments: Any) -> None:
        try:
            answer, data = getattr(node, name)(**arguments)
        except Exception as reason:  # every error is reported to the other process
            known = isinstance(reason, CellError)
            answer, data = {"error": str(reason) if known else f"{type(reason).__name__}: {reason}"}, b""
        send({"id": number, **answer}, data)

    try:
        rospy = import_module("rospy")
        node = Node(rospy, json.loads(connection.recv_bytes()))
    except ImportError as reason:
        send({"id": 0, "missing": str(reason)})
        return
    send({"id": 0, "uri": rospy.get_node_uri()})
    while True:
        request = json.loads(connection.recv_bytes())
        threading.Thread(target=act, kwargs=request, daemon=True).start()


def main() -> None:
    """Serve, then unregister from the master within a timeout."""
    try:
        serve(Connection(int(sys.argv[1])))
    except (EOFError, OSError):
        rospy = sys.modules.get("rospy")
        if rospy is not None:
            leaving = threading.Thread(target=rospy.signal_shutdown, args=("done",), daemon=True)
            leaving.start()
            leaving.join(UNREGISTER_TIMEOUT)
    os._exit(0)  # rospy's threads may block without a timeout


if __name__ == "__main__":
    main()
