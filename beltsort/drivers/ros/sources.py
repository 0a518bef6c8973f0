"""Sources of scans: point clouds, or depth images with the camera's parameters."""

from collections.abc import Mapping
from typing import Any, Protocol

from beltsort.drivers.deadline import Deadline
from beltsort.drivers.ros.clouds import Cloud, points_of
from beltsort.drivers.ros.images import points_of_image
from beltsort.drivers.ros.link import Link
from beltsort.errors import CellError
from beltsort.geometry import Points


class Source(Protocol):
    """What a camera publishes."""

    topic: str
    """The topic of the scans."""

    @property
    def subscribe(self) -> Mapping[str, str]:
        """Type of each topic."""

    def points(self, link: Link, message: Mapping[str, Any], data: bytes, deadline: Deadline) -> Points:
        """Return the points of a message on the topic."""


class CloudSource:
    """Point clouds.

    Parameters
    ----------
    topic
        Topic of sensor_msgs/PointCloud2.
    """

    def __init__(self, topic: str) -> None:
        self.topic, self.subscribe = topic, {topic: "sensor_msgs/PointCloud2"}

    def points(self, _link: Link, message: Mapping[str, Any], data: bytes, _deadline: Deadline) -> Points:
        """Return the points of a cloud."""
        fields = {field["name"]: (field["offset"], field["datatype"]) for field in message["fields"]}
        size = message["height"], message["width"]
        steps = message["point_step"], message["row_step"]
        return points_of(Cloud(*size, fields, message["is_bigendian"], *steps, data))


class ImageSource:
    """Depth images.

    Parameters
    ----------
    topic, info_topic
        Topics of sensor_msgs/Image and sensor_msgs/CameraInfo.
    """

    def __init__(self, topic: str, info_topic: str) -> None:
        self.topic, self._info_topic = topic, info_topic
        self.subscribe = {topic: "sensor_msgs/Image", info_topic: "sensor_msgs/CameraInfo"}

    def points(self, link: Link, message: Mapping[str, Any], data: bytes, deadline: Deadline) -> Points:
        """Return the points of a depth image."""
        info = link.newest(self._info_topic, deadline, wait=deadline.left()).values["message"]
        if info is None:
            raise CellError(
                f"no camera info on {self._info_topic}, expected the camera's parameters; correct the topic"
            )
        return points_of_image(message, info, data)
