"""Recording of a cell's scans.

The format is rosbag2 with mcap, which contains the message definitions, is written in chunks, and is read by
ROS 2, Foxglove and `Replay`. Coordinates are rounded to float32 (an error of at most 60 nm at 1 m), times to
nanoseconds; poses are converted to quaternions (error 1e-15). A cloud of one row is read as shape (n, 3).
"""

from pathlib import Path
from threading import Lock
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from beltsort.cell.protocols import Scan
from beltsort.drivers.replay.bag import NANOSECONDS, rosbags
from beltsort.drivers.replay.options import OBJECTS, SCANS, VIEWPOINTS, WORLD
from beltsort.drivers.replay.poses import TRANSFORMS
from beltsort.drivers.ros.clouds import packed
from beltsort.drivers.ros.frames import quaternion_of
from beltsort.errors import CellError

TYPES = {
    SCANS: "sensor_msgs/msg/PointCloud2",
    TRANSFORMS: "tf2_msgs/msg/TFMessage",
    VIEWPOINTS: "std_msgs/msg/Header",
    OBJECTS: "std_msgs/msg/Header",
}


class Recorder:
    """Writes scans, the camera's poses, and the stops of arm and belt to a new bag.

    The bag can be read after it was closed.

    Parameters
    ----------
    path
        A directory that does not exist yet.

    Raises
    ------
    CellError
        If it exists or cannot be written, or `rosbags` is not installed.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        library = rosbags()
        self._types = library.typesys.get_typestore(library.typesys.Stores.ROS2_HUMBLE)
        self._lock = Lock()
        try:
            storage = library.rosbag2.StoragePlugin.MCAP
            self._writer = library.rosbag2.Writer(self.path, version=8, storage_plugin=storage)
            self._writer.open()
        except (library.rosbag2.WriterError, OSError) as reason:
            raise CellError(f"cannot record to {self.path}: {reason}; name a new directory") from reason
        self._topics = {
            topic: self._writer.add_connection(topic, kind, typestore=self._types)
            for topic, kind in TYPES.items()
        }

    def scan(self, scan: Scan) -> None:
        """Write a scan and the camera's pose."""
        cloud = packed(scan.points)
        fields = [
            self._new("sensor_msgs/msg/PointField", name=name, offset=offset, datatype=kind, count=1)
            for name, (offset, kind) in cloud.fields.items()
        ]
        message = self._new(
            TYPES[SCANS],
            header=self._header(scan.stamp, scan.frame),
            height=cloud.height,
            width=cloud.width,
            fields=fields,
            is_bigendian=cloud.big_endian,
            point_step=cloud.point_step,
            row_step=cloud.row_step,
            data=_bytes(cloud.data),
            is_dense=False,
        )
        transform = self._transform(scan)
        self._write(TRANSFORMS, scan.stamp, self._new(TYPES[TRANSFORMS], transforms=[transform]))
        self._write(SCANS, scan.stamp, message)

    def stopped(self, topic: str, name: str, time: float) -> None:
        """Write that the arm (topic `VIEWPOINTS`) or the belt (`OBJECTS`) stopped at `name`."""
        self._write(topic, time, self._header(time, name))

    def close(self) -> None:
        """Finish the bag."""
        with self._lock:
            if self._writer.storage is not None:
                self._writer.close()

    def __enter__(self) -> Self:
        """Use the recorder as a context that finishes the bag."""
        return self

    def __exit__(self, *_: object) -> None:
        """Finish the bag."""
        self.close()

    def _write(self, topic: str, time: float, message: Any) -> None:
        data = self._types.serialize_cdr(message, TYPES[topic])
        with self._lock:
            if self._writer.storage is None:
                raise CellError(f"the recording {self.path} is closed; record to a new directory")
            self._writer.write(self._topics[topic], _nanoseconds(time), data)

    def _new(self, kind: str, **values: Any) -> Any:
        return self._types.types[kind](**values)

    def _header(self, time: float, frame: str) -> Any:
        second, rest = divmod(_nanoseconds(time), NANOSECONDS)
        stamp = self._new("builtin_interfaces/msg/Time", sec=second, nanosec=rest)
        return self._new("std_msgs/msg/Header", stamp=stamp, frame_id=frame)

    def _transform(self, scan: Scan) -> Any:
        x, y, z, w = quaternion_of(scan.world_from_camera)
        origin = dict(zip("xyz", scan.world_from_camera[:3, 3].tolist(), strict=True))
        return self._new(
            "geometry_msgs/msg/TransformStamped",
            header=self._header(scan.stamp, WORLD),
            child_frame_id=scan.frame,
            transform=self._new(
                "geometry_msgs/msg/Transform",
                translation=self._new("geometry_msgs/msg/Vector3", **origin),
                rotation=self._new("geometry_msgs/msg/Quaternion", x=x, y=y, z=z, w=w),
            ),
        )


def _bytes(data: bytes | memoryview) -> NDArray[np.uint8]:
    return np.frombuffer(data, np.uint8)


def _nanoseconds(time: float) -> int:
    whole = int(time // 1.0)
    return whole * NANOSECONDS + round((time - whole) * NANOSECONDS)
