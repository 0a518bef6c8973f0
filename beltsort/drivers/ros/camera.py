"""A camera that publishes point clouds or depth images."""

import numpy as np

from beltsort.cell.commands import TIMEOUT, CommandError, Outcome
from beltsort.cell.protocols import Scan
from beltsort.drivers.deadline import Deadline
from beltsort.drivers.ros.checks import check_pose
from beltsort.drivers.ros.device import Received, RosDevice
from beltsort.drivers.ros.joints import joints_of, joints_text, standing_at
from beltsort.drivers.ros.link import MakeLink, Topics
from beltsort.drivers.ros.options import CameraOptions
from beltsort.drivers.ros.sources import Source
from beltsort.errors import CellError
from beltsort.geometry import Pose

CLOCK_TOLERANCE = 0.1
"""Largest time by which a stamp may be later than its arrival, seconds: the error of clock "
"synchronisation."""


class RosCamera(RosDevice):
    """A camera on ROS.

    A scan that is too old, in another frame, empty, truncated, without a finite point or without a known
    pose is ignored, and the device waits for the next one.

    Parameters
    ----------
    options
        Its topic and the source of its pose.
    source
        What it publishes.
    link
        Function that returns the link.
    """

    def __init__(self, options: CameraOptions, source: Source, link: MakeLink) -> None:
        joints = {options.joint_topic: "sensor_msgs/JointState"} if options.joint_topic else {}
        topics = Topics(
            subscribe={**source.subscribe, **joints},
            joints=next(iter(options.taught.values()), ()),
            tf=bool(options.world_frame),
        )
        super().__init__(link("camera", topics), source.topic)
        self._options, self._source = options, source

    def stop(self) -> None:
        """Do nothing: nothing moves."""

    def scan(self, *, not_before: float, timeout: float = TIMEOUT) -> Scan:
        """Return a scan whose stamp is at or after `not_before`, seconds of the monotonic clock.

        Raises
        ------
        CommandError
            If there is none in time; the message gives the problem of the last one.
        """
        if not np.isfinite(not_before):
            raise CellError(f"not_before is {not_before}, expected a time, seconds; give a number")
        deadline = Deadline(timeout)
        self._link.connect(deadline.left())
        number, refused = 0, "none came"
        while (received := self._await(deadline, number, not_before)) is not None:
            number = received.number
            try:
                return self._scan_of(received, not_before, deadline)
            except CellError as reason:
                refused = str(reason)
        raise CommandError(
            f"no usable scan on {self._topic} within {timeout:g} s, expected one; the last: {refused}",
            Outcome.NOT_DONE,
        )

    def _scan_of(self, received: Received, not_before: float, deadline: Deadline) -> Scan:
        if received.ahead > CLOCK_TOLERANCE:
            raise CellError(
                f"its stamp {received.ros_stamp:.3f} is {received.ahead:.3f} s later than its arrival, "
                f"expected at most {CLOCK_TOLERANCE:g} s; synchronise the clocks of camera and cell"
            )
        if received.stamp < not_before:
            raise CellError(
                f"its stamp {received.ros_stamp:.3f} is {not_before - received.stamp:.3f} s too old, "
                "expected one after arm and belt have stopped; check the camera and the clocks"
            )
        frame = received.message["header"]["frame_id"].lstrip("/")
        if frame != self._options.frame.lstrip("/"):
            raise CellError(
                f"it is in the frame {frame!r}, expected {self._options.frame!r}; take the scans of "
                "the optical frame"
            )
        points = self._source.points(self._link, received.message, received.data, deadline)
        return Scan(points, self._pose(frame, received.ros_stamp, deadline), received.stamp, frame)

    def _pose(self, frame: str, stamp: float, deadline: Deadline) -> Pose:
        if self._options.world_frame:
            return self._pose_in(self._options.world_frame, frame, stamp, self._options.pose_age, deadline)
        return self._taught_pose(deadline) if self._options.taught else np.full((4, 4), np.nan)

    def _taught_pose(self, deadline: Deadline) -> Pose:
        """Return the pose of the viewpoint at which the arm stands."""
        topic = self._options.joint_topic
        message = self._link.newest(topic, deadline, wait=deadline.left()).values["message"]
        if message is None:
            raise CellError(f"no joint states on {topic}, expected the arm's position; start their publisher")
        joints = joints_of(message)
        name = standing_at(self._options.taught, joints, self._options.tolerance)
        if name is None:
            raise CellError(
                f"the arm is at {joints_text(joints)}, expected within {self._options.tolerance:g} of a "
                "taught viewpoint; move it to one"
            )
        return check_pose(name, self._options.poses[name])
