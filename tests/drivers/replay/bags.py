"""Bags as others write them: the same messages in each of the three formats."""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from rosbags import rosbag1, rosbag2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from beltsort.drivers.ros.clouds import Cloud, packed
from beltsort.geometry import Points

FORMATS = ("bag", "sqlite3", "mcap")
SECOND = 10**9


class Message(NamedTuple):
    topic: str
    kind: str
    time: float
    build: Callable[["Types"], Any]


class Types:
    """Builds messages of ROS 1 or 2."""

    def __init__(self, ros1: bool) -> None:
        self.ros1 = ros1
        self.store = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_HUMBLE)
        if ros1:
            definition = "geometry_msgs/TransformStamped[] transforms"
            self.store.register(get_types_from_msg(definition, "tf2_msgs/msg/TFMessage"))

    def new(self, kind: str, **values: Any) -> Any:
        return self.store.types[kind](**values)

    def header(self, time: float, frame: str) -> Any:
        second, rest = divmod(round(time * SECOND), SECOND)
        stamp = self.new("builtin_interfaces/msg/Time", sec=second, nanosec=rest)
        extra = {"seq": 0} if self.ros1 else {}
        return self.new("std_msgs/msg/Header", stamp=stamp, frame_id=frame, **extra)

    def pose(self, kind: str, origin: Iterable[float]) -> dict[str, Any]:
        x, y, z = origin
        quaternion = self.new("geometry_msgs/msg/Quaternion", x=1.0, y=0.0, z=0.0, w=0.0)
        place = self.new(kind, x=x, y=y, z=z)
        return {"place": place, "quaternion": quaternion}


def cloud(
    time: float, points: Points | Cloud, topic: str = "/camera/points", frame: str = "camera"
) -> Message:
    content = packed(points) if isinstance(points, np.ndarray) else points

    def build(types: Types) -> Any:
        fields = [
            types.new("sensor_msgs/msg/PointField", name=name, offset=offset, datatype=kind, count=1)
            for name, (offset, kind) in content.fields.items()
        ]
        return types.new(
            "sensor_msgs/msg/PointCloud2",
            header=types.header(time, frame),
            height=content.height,
            width=content.width,
            fields=fields,
            is_bigendian=content.big_endian,
            point_step=content.point_step,
            row_step=content.row_step,
            data=np.frombuffer(content.data, np.uint8),
            is_dense=False,
        )

    return Message(topic, "sensor_msgs/msg/PointCloud2", time, build)


def joints(time: float, positions: dict[str, float]) -> Message:
    def build(types: Types) -> Any:
        return types.new(
            "sensor_msgs/msg/JointState",
            header=types.header(time, ""),
            name=list(positions),
            position=np.array(list(positions.values())),
            velocity=np.empty(0),
            effort=np.empty(0),
        )

    return Message("/joint_states", "sensor_msgs/msg/JointState", time, build)


def transform(time: float, parent: str, child: str, origin: Iterable[float], topic: str = "/tf") -> Message:
    def build(types: Types) -> Any:
        made = types.pose("geometry_msgs/msg/Vector3", origin)
        stamped = types.new(
            "geometry_msgs/msg/TransformStamped",
            header=types.header(time, parent),
            child_frame_id=child,
            transform=types.new(
                "geometry_msgs/msg/Transform", translation=made["place"], rotation=made["quaternion"]
            ),
        )
        return types.new("tf2_msgs/msg/TFMessage", transforms=[stamped])

    return Message(topic, "tf2_msgs/msg/TFMessage", time, build)


def pose(time: float, origin: Iterable[float]) -> Message:
    def build(types: Types) -> Any:
        made = types.pose("geometry_msgs/msg/Point", origin)
        inner = types.new("geometry_msgs/msg/Pose", position=made["place"], orientation=made["quaternion"])
        return types.new("geometry_msgs/msg/PoseStamped", header=types.header(time, "world"), pose=inner)

    return Message("/camera/pose", "geometry_msgs/msg/PoseStamped", time, build)


def stop(time: float, topic: str, name: str) -> Message:
    return Message(topic, "std_msgs/msg/Header", time, lambda types: types.header(time, name))


def write(directory: Path, form: str, messages: Iterable[Message], odd: bool = False) -> Path:
    """Write a bag and return its path; if `odd`, with a topic whose definition names a missing type."""
    types = Types(form == "bag")
    path = directory / ("record.bag" if form == "bag" else f"record_{form}")
    if form == "bag":
        writer: Any = rosbag1.Writer(path)
    else:
        storage = rosbag2.StoragePlugin[form.upper()]
        writer = rosbag2.Writer(path, version=8, storage_plugin=storage)
    serialize = types.store.serialize_ros1 if form == "bag" else types.store.serialize_cdr
    topics: dict[str, Any] = {}
    with writer:
        if odd:
            proof: dict[str, Any] = (
                {"md5sum": "0" * 32} if form == "bag" else {"rihs01": "RIHS01_" + 64 * "0"}
            )
            kind = "acme/msg/Odd"
            connection = writer.add_connection("/odd", kind, msgdef="acme/Missing thing", **proof)
            writer.write(connection, 0, b"\x00\x01\x00\x00")
        for message in messages:
            if message.topic not in topics:
                topics[message.topic] = writer.add_connection(
                    message.topic, message.kind, typestore=types.store
                )
            data = serialize(message.build(types), message.kind)
            writer.write(topics[message.topic], round(message.time * SECOND), bytes(data))
    return path
