"""The camera's pose of a recorded scan."""

from typing import Any

from beltsort.drivers.replay.bag import NANOSECONDS, Bag, seconds
from beltsort.drivers.replay.index import Index, Place
from beltsort.drivers.replay.options import ReplayOptions
from beltsort.drivers.ros.frames import Frames
from beltsort.geometry import Pose

TRANSFORMS = "/tf"

LATENCY = 1.0
"""Largest difference between the times at which a scan and its pose were written, seconds."""


def recorded_pose(
    bag: Bag, options: ReplayOptions, index: Index, place: Place, frame: str, stamp: float
) -> Pose:
    """Return `world_from_camera` of a recorded scan, shape (4, 4).

    Parameters
    ----------
    bag, options, index
        The recording.
    place
        Position of the scan in the bag.
    frame
        Name of the camera frame.
    stamp
        Stamp of the scan, seconds.

    Raises
    ------
    CellError
        If no pose is recorded near the stamp.
    """
    frames = Frames(options.pose_age)
    for parent, child, translation, quaternion in index.frames:
        frames.add(parent, child, None, translation, quaternion)
    reach = int((options.pose_age + LATENCY) * NANOSECONDS)
    start, stop = max(0, place.time - reach), place.time + reach
    for _, _, message in bag.messages({options.pose_topic or TRANSFORMS}, start, stop):
        if options.pose_topic:
            header, translation, rotation = message.header, message.pose.position, message.pose.orientation
            _add(frames, header, frame, translation, rotation)
        else:
            for each in message.transforms:
                transform = each.transform
                _add(frames, each.header, each.child_frame_id, transform.translation, transform.rotation)
    return frames.pose(options.world_frame, frame, stamp)


def _add(frames: Frames, header: Any, child: str, t: Any, q: Any) -> None:
    frames.add(header.frame_id, child, seconds(header.stamp), [t.x, t.y, t.z], [q.x, q.y, q.z, q.w])
