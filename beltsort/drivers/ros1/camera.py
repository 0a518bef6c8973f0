"""A camera that publishes point clouds."""

from typing import Any

import numpy as np

from beltsort.cell.commands import TIMEOUT, CommandError, Outcome
from beltsort.cell.protocols import Scan
from beltsort.drivers.ros.checks import check_pose
from beltsort.drivers.ros.clouds import Cloud, points_of
from beltsort.drivers.ros.joints import standing_at, told
from beltsort.drivers.ros1.device import News, Ros1Device
from beltsort.drivers.ros1.link import Deadline, Link
from beltsort.drivers.ros1.options import Ros1CameraOptions
from beltsort.errors import CellError
from beltsort.geometry import Pose

AHEAD = 0.1
"""Seconds by which a stamp may be later than its arrival: no clocks are synchronised better than that."""


class Ros1Camera(Ros1Device):
    """A camera on ROS 1.

    A cloud that is too old, in another frame, empty, truncated, without a finite point or without a known
    pose is passed over, and the next one waited for.

    Parameters
    ----------
    options
        Its topic and how its pose is known.
    """

    def __init__(self, options: Ros1CameraOptions) -> None:
        joints = {options.joint_topic: "sensor_msgs/JointState"} if options.joint_topic else {}
        link = Link(
            options,
            "camera",
            subscribe={options.topic: "sensor_msgs/PointCloud2", **joints},
            joints=next(iter(options.taught.values()), ()),
            tf=bool(options.world_frame),
            pose_age=options.pose_age,
        )
        super().__init__(link, options.topic)
        self._options = options

    def stop(self) -> None:
        """Do nothing: nothing moves."""

    def scan(self, *, not_before: float, timeout: float = TIMEOUT) -> Scan:
        """Return a scan whose stamp is at or after `not_before`, seconds of the monotonic clock.

        Raises
        ------
        CommandError
            If none comes in time; the message says what was wrong with the last cloud.
        """
        if not np.isfinite(not_before):
            raise CellError(f"not_before is {not_before}, expected a time, seconds; give a number")
        deadline = Deadline(timeout)
        self._link.connect(deadline.left())
        number, refused = 0, "none came"
        while (news := self._await(deadline, number, not_before)) is not None:
            number = news.number
            try:
                return self._scan_of(news, not_before, deadline)
            except CellError as reason:
                refused = str(reason)
        raise CommandError(
            f"no usable cloud on {self._topic} within {timeout:g} s, expected one; the last: {refused}",
            Outcome.NOT_DONE,
        )

    def _scan_of(self, news: News, not_before: float, deadline: Deadline) -> Scan:
        if news.ahead > AHEAD:
            raise CellError(
                f"its stamp {news.ros_stamp:.3f} is {news.ahead:.3f} s later than its arrival, expected at "
                f"most {AHEAD:g} s; synchronise the clocks of camera and cell"
            )
        if news.stamp < not_before:
            raise CellError(
                f"its stamp {news.ros_stamp:.3f} is {not_before - news.stamp:.3f} s too old, expected one "
                "after the stop of everything that moves; look at the camera, and at the clocks"
            )
        frame = news.message["header"]["frame_id"].lstrip("/")
        if frame != self._options.frame.lstrip("/"):
            raise CellError(
                f"it is in the frame {frame!r}, expected {self._options.frame!r}; take the cloud of the "
                "optical frame"
            )
        points = points_of(_cloud(news.message, news.data))
        return Scan(points, self._pose(frame, news.ros_stamp, deadline), news.stamp, frame)

    def _pose(self, frame: str, stamp: float, deadline: Deadline) -> Pose:
        if self._options.world_frame:
            return self._pose_in(self._options.world_frame, frame, stamp, deadline)
        return self._taught_pose(deadline) if self._options.taught else np.full((4, 4), np.nan)

    def _taught_pose(self, deadline: Deadline) -> Pose:
        """Return the pose of the viewpoint at which the arm stands."""
        topic = self._options.joint_topic
        message = self._link.newest(topic, deadline, wait=deadline.left()).values["message"]
        if message is None:
            raise CellError(f"{topic} does not tell where the arm stands; start what publishes there")
        joints = joints_of(message)
        name = standing_at(self._options.taught, joints, self._options.tolerance)
        if name is None:
            raise CellError(f"the arm stands at no viewpoint ({told(joints)}); move it to one")
        return check_pose(name, self._options.poses[name])


def joints_of(message: dict[str, Any]) -> dict[str, float]:
    """Return the positions of a JointState by joint."""
    return dict(zip(message["name"], message["position"], strict=False))


def _cloud(message: dict[str, Any], data: bytes) -> Cloud:
    return Cloud(
        message["height"],
        message["width"],
        {field["name"]: (field["offset"], field["datatype"]) for field in message["fields"]},
        message["is_bigendian"],
        message["point_step"],
        message["row_step"],
        data,
    )
