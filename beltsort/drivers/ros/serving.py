"""What the node programs of ROS 1 and ROS 2 share: requests from a socket, received messages, transforms.

A node program runs in a process of its own: some calls of rospy and rclpy block without a timeout, and a
process can be killed. Requests are JSON over a socket, answers are JSON and, for scans, bytes.

Only the standard library is imported, since the Python of a ROS 2 distribution has no other packages of
beltsort's.
"""

import json
import threading
import time
from array import array
from collections import deque
from collections.abc import Callable, Iterable
from multiprocessing.connection import Connection
from typing import Any, NamedTuple

HISTORY = 10.0
"""Time for which transforms are kept, seconds."""

JOINT_STATE, CLOUD, IMAGE = "sensor_msgs/JointState", "sensor_msgs/PointCloud2", "sensor_msgs/Image"
SCANS = (CLOUD, IMAGE)
"""Types of large messages, of which only the newest is kept in a queue."""

QUEUE = 100
"""Queue size of other topics."""

Reply = tuple[dict[str, Any], bytes]
"""An answer: plain values, and the bytes of a scan."""

Transform = tuple[str, str, float | None, list[float], list[float]]
"""Parent, child, stamp (seconds, None if static), translation and quaternion (x, y, z, w)."""


class Arrived(NamedTuple):
    """A message: its number, its arrival on the monotonic clock and in ROS time, its content and sender."""

    number: int
    at: float
    ros_time: float
    message: Any
    sender: str = ""

    @property
    def stamp(self) -> float:
        """Stamp in ROS time; the time of arrival if it has none."""
        header = getattr(self.message, "header", None)
        return (0.0 if header is None else seconds_of(header.stamp)) or self.ros_time

    @property
    def age(self) -> float:
        """Time from stamp to arrival, seconds; negative if clocks are not synchronised."""
        return self.ros_time - self.stamp


class Mailbox:
    """The newest message of a topic; of joint states, the newest that contains the given joints.

    Parameters
    ----------
    clock
        Function that returns ROS time, seconds.
    joints
        Names of joints.
    """

    def __init__(self, clock: Callable[[], float], joints: Iterable[str] = ()) -> None:
        self._clock, self._joints = clock, set(joints)
        self._arrival = threading.Condition()
        self._newest = Arrived(0, 0.0, 0.0, None)

    def put(self, message: Any, sender: str) -> None:
        """Keep a message, unless it is the joint states of another part of the robot."""
        if self._joints and not self._joints <= set(message.name):
            return
        with self._arrival:
            number = self._newest.number + 1
            self._newest = Arrived(number, time.monotonic(), self._clock(), message, sender)
            self._arrival.notify_all()

    def newest(self, after: int, wait: float) -> Arrived:
        """Return the newest message if its number is above `after`.

        Waits for it for `wait` seconds; the content is None if there is none.
        """
        with self._arrival:
            self._arrival.wait_for(lambda: self._newest.number > after, wait)
            return self._newest if self._newest.number > after else Arrived(after, 0.0, 0.0, None)


class Transforms:
    """The transforms of the last seconds, as tf published them."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._moving: dict[str, deque[Transform]] = {}
        self._static: dict[str, Transform] = {}

    def add(self, message: Any, *, static: bool) -> None:
        """Keep the transforms of a tf2_msgs/TFMessage."""
        with self._lock:
            for transform in map(_transform_of, message.transforms):
                if static:
                    self._static[transform[1]] = (*transform[:2], None, *transform[3:])
                else:
                    self._keep(transform)

    def nearest(self, stamp: float) -> list[Transform]:
        """Return each frame's transform nearest to a time (seconds), static ones included."""

        def difference(transform: Transform) -> float:
            return abs((transform[2] or 0.0) - stamp)

        with self._lock:
            moving = {child: min(history, key=difference) for child, history in self._moving.items()}
            return list({**moving, **self._static}.values())

    def _keep(self, transform: Transform) -> None:
        history = self._moving.setdefault(transform[1], deque())
        history.append(transform)
        while (history[0][2] or 0.0) < (transform[2] or 0.0) - HISTORY:
            history.popleft()


def _transform_of(stamped: Any) -> Transform:
    """Return a geometry_msgs/TransformStamped as numbers; names of frames without a leading slash."""
    t, q = stamped.transform.translation, stamped.transform.rotation
    parent, child = stamped.header.frame_id.lstrip("/"), stamped.child_frame_id.lstrip("/")
    return parent, child, seconds_of(stamped.header.stamp), [t.x, t.y, t.z], [q.x, q.y, q.z, q.w]


def seconds_of(stamp: Any) -> float:
    """Return a stamp of ROS 1 or ROS 2 in seconds."""
    return float(stamp.to_sec()) if hasattr(stamp, "to_sec") else float(stamp.sec + 1e-9 * stamp.nanosec)


def answered(arrived: Arrived, not_before: float) -> Reply:
    """Return the answer for a message, and its bytes if it is not stale.

    "stamp" is converted to the monotonic clock by the message's age at arrival, so that setting a clock does
    not change the order of events.
    """
    message = arrived.message
    if message is None:
        return {"number": arrived.number, "message": None}, b""
    stamp = arrived.at - max(0.0, arrived.age)
    answer = {
        "number": arrived.number,
        "stamp": stamp,
        "ros_stamp": arrived.stamp,
        "ahead": max(0.0, -arrived.age),
        "node": arrived.sender,
        "message": plain(message),
    }
    data = getattr(message, "data", b"")
    fresh = isinstance(data, bytes | array) and stamp >= not_before
    return answer, bytes(data) if fresh else b""


def plain(value: Any) -> Any:
    """Return a message as dictionaries, lists and numbers, without its bytes."""
    if hasattr(value, "to_sec"):
        return value.to_sec()
    if hasattr(value, "get_fields_and_field_types"):  # ROS 2: its slots have other names
        return {name: plain(getattr(value, name)) for name in value.get_fields_and_field_types()}
    if hasattr(value, "__slots__"):
        return {name: plain(getattr(value, name)) for name in value.__slots__}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, bytes) or (isinstance(value, array) and value.typecode == "B"):
        return None
    return value.tolist() if hasattr(value, "tolist") else value


def serve(connection: Connection, start: Callable[[dict[str, Any]], tuple[object, dict[str, Any]]]) -> None:
    """Start a node and answer requests, until the socket closes.

    Parameters
    ----------
    connection
        The socket.
    start
        Function of the setup that returns the node, an object with a method for each request, and the answer
        to the setup.

    Raises
    ------
    EOFError, OSError
        When the socket closes.
    """
    sending = threading.Lock()

    def send(answer: dict[str, Any], data: bytes = b"") -> None:
        with sending:
            connection.send_bytes(json.dumps(answer).encode())
            connection.send_bytes(data)

    def act(number: int, name: str, **arguments: Any) -> None:
        try:
            answer, data = getattr(node, name)(**arguments)
        except Exception as reason:  # every error is reported to the other process
            answer, data = {"error": f"{type(reason).__name__}: {reason}"}, b""
        send({"id": number, **answer}, data)

    try:
        node, started = start(json.loads(connection.recv_bytes()))
    except ImportError as reason:
        send({"id": 0, "missing": str(reason)})
        return
    send({"id": 0, **started})
    while True:
        request = json.loads(connection.recv_bytes())
        threading.Thread(target=act, kwargs=request, daemon=True).start()
