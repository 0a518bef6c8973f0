"""What a bag holds: when which viewpoint and object was reached, and where its scans are."""

from bisect import bisect_right
from dataclasses import dataclass, field
from typing import Any, NamedTuple, TypeAlias

from beltsort.cell.replay.bag import Bag, seconds
from beltsort.cell.replay.options import ReplayOptions
from beltsort.cell.ros.joints import standing_at
from beltsort.errors import CellError

STATIC = "/tf_static"

Transform: TypeAlias = tuple[str, str, list[float], list[float]]
"""Parent, child, translation (metres) and quaternion (x, y, z, w)."""


class Place(NamedTuple):
    """Where a scan is: when it was written (nanoseconds), and how many of that time precede it."""

    time: int
    repeat: int


@dataclass
class Timeline:
    """What held from which time on; only changes are kept."""

    times: list[float] = field(default_factory=list)
    states: list[str | None] = field(default_factory=list)

    def add(self, time: float, state: str | None) -> None:
        """Take in a state, not older than the last one."""
        if not self.states or self.states[-1] != state:
            self.times.append(time)
            self.states.append(state)

    def at(self, time: float) -> str | None:
        """Return what held at a time; None before the first state."""
        before = bisect_right(self.times, time)
        return self.states[before - 1] if before else None


@dataclass(frozen=True)
class Entry:
    """A recorded scan: its stamp (seconds), viewpoint and object (None if neither told), and where it is."""

    stamp: float
    viewpoint: str | None
    object: str | None
    place: Place


@dataclass(frozen=True)
class Index:
    """All scans of a bag in the order of their stamps, the objects' arrivals, and the static frames."""

    entries: list[Entry]
    objects: Timeline
    frames: list[Transform]


def read_index(bag: Bag, options: ReplayOptions) -> Index:
    """Go through a bag once.

    Raises
    ------
    CellError
        If the bag is damaged or lacks what the options name.
    """
    _check_topics(bag, options)
    viewpoints, objects = Timeline(), Timeline()
    scans: list[tuple[float, Place]] = []
    static: list[Transform] = []
    for topic, time, message in bag.messages(
        {options.scan_topic, options.object_topic, _viewpoint_topic(options), STATIC}
    ):
        if topic == options.scan_topic:
            repeat = scans[-1][1].repeat + 1 if scans and scans[-1][1].time == time else 0
            scans.append((seconds(message.header.stamp), Place(time, repeat)))
        elif topic == options.object_topic:
            objects.add(seconds(message.stamp), message.frame_id)
        elif topic == options.viewpoint_topic:
            viewpoints.add(seconds(message.stamp), message.frame_id)
        elif topic == options.joint_topic:
            joints = dict(zip(message.name, message.position.tolist(), strict=False))
            if joints.keys() >= next(iter(options.taught.values())).keys():
                name = standing_at(options.taught, joints, options.tolerance)
                viewpoints.add(seconds(message.header.stamp), name)
        else:
            static += [_plain(transform) for transform in message.transforms]
    if not scans:
        raise CellError(f"{bag.path} has no message on {options.scan_topic!r}, expected scans; record again")
    entries = [Entry(stamp, viewpoints.at(stamp), objects.at(stamp), place) for stamp, place in sorted(scans)]
    return Index(entries, objects, static)


def _viewpoint_topic(options: ReplayOptions) -> str:
    return options.joint_topic or options.viewpoint_topic


def _check_topics(bag: Bag, options: ReplayOptions) -> None:
    bag.require(options.scan_topic, "sensor_msgs/msg/PointCloud2")
    told_by = "sensor_msgs/msg/JointState" if options.joint_topic else "std_msgs/msg/Header"
    bag.require(_viewpoint_topic(options), told_by)
    if options.object_topic in bag.topics:
        bag.require(options.object_topic, "std_msgs/msg/Header")
    if options.pose_topic:
        bag.require(options.pose_topic, "geometry_msgs/msg/PoseStamped")


def _plain(message: Any) -> Transform:
    t, q = message.transform.translation, message.transform.rotation
    return message.header.frame_id, message.child_frame_id, [t.x, t.y, t.z], [q.x, q.y, q.z, q.w]
