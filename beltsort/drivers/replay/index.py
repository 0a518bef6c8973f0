"""The index of a bag: times at which viewpoints and objects were reached, and positions of its scans."""

from bisect import bisect_right
from dataclasses import dataclass, field
from itertools import combinations, pairwise
from typing import Any, NamedTuple, TypeAlias

from beltsort.drivers.replay.bag import NANOSECONDS, Bag, seconds
from beltsort.drivers.replay.options import ReplayOptions
from beltsort.drivers.ros.joints import standing_at
from beltsort.errors import CellError

STATIC = "/tf_static"

Transform: TypeAlias = tuple[str, str, list[float], list[float]]
"""Parent, child, translation (metres) and quaternion (x, y, z, w)."""


class Place(NamedTuple):
    """Position of a scan: the time at which it was written (nanoseconds) and its rank among equal times."""

    time: int
    repeat: int


@dataclass
class Timeline:
    """A piecewise constant state over time; only changes are stored."""

    times: list[float] = field(default_factory=list)
    states: list[str | None] = field(default_factory=list)

    def add(self, time: float, state: str | None) -> None:
        """Add a state, not older than the last one."""
        if not self.states or self.states[-1] != state:
            self.times.append(time)
            self.states.append(state)

    def at(self, time: float) -> str | None:
        """Return the state at a time; None before the first state."""
        before = bisect_right(self.times, time)
        return self.states[before - 1] if before else None


@dataclass(frozen=True)
class Entry:
    """A recorded scan: its stamp (seconds), viewpoint and object (None if unknown), and its position."""

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


CLOCK_ERROR = 1.0
"""Largest difference between the clocks of a bag, seconds."""

FEW = 3
"""Topics with fewer messages are not checked, since these may be latched messages of an earlier time."""


class Clocks:
    """Checks that the stamps of a bag's topics come from clocks that agree and were not set back."""

    def __init__(self, bag: Bag) -> None:
        self._bag = bag
        self._stamps: dict[str, list[float]] = {}
        self._delays: dict[str, list[float]] = {}

    def seen(self, topic: str, time: int, stamp: Any) -> float:
        """Add a message that was written at `time` (nanoseconds); return its stamp, seconds."""
        stamped = seconds(stamp)
        self._stamps.setdefault(topic, []).append(stamped)
        self._delays.setdefault(topic, []).append(time / NANOSECONDS - stamped)
        return stamped

    def check(self) -> None:
        """Check the stamps, by which scans are assigned to viewpoints.

        Raises
        ------
        CellError
            If a clock was set back, or the clocks of two topics differ.
        """
        for topic, stamps in self._stamps.items():
            back = max((before - after for before, after in pairwise(stamps)), default=0.0)
            if back > CLOCK_ERROR:
                raise CellError(
                    f"{self._bag.path}: the clock that stamps {topic} jumps back by {back:.3f} s, expected "
                    f"less than {CLOCK_ERROR:g} s; do not set clocks while recording"
                )
        least = {topic: min(delays) for topic, delays in self._delays.items() if len(delays) >= FEW}
        for (one, first), (other, second) in combinations(least.items(), 2):
            if abs(first - second) > CLOCK_ERROR:
                raise CellError(
                    f"{self._bag.path}: the clocks that stamp {one} and {other} differ by "
                    f"{abs(first - second):.3f} s, expected less than {CLOCK_ERROR:g} s; synchronise them "
                    "and record again"
                )


def read_index(bag: Bag, options: ReplayOptions) -> Index:
    """Read a bag once and return its index.

    Raises
    ------
    CellError
        If the bag is damaged or lacks what the options name.
    """
    _check_topics(bag, options)
    viewpoints, objects, clocks = Timeline(), Timeline(), Clocks(bag)
    scans: list[tuple[float, Place]] = []
    static: list[Transform] = []
    for topic, time, message in bag.messages(
        {options.scan_topic, options.object_topic, _viewpoint_topic(options), STATIC}
    ):
        if topic == options.scan_topic:
            repeat = scans[-1][1].repeat + 1 if scans and scans[-1][1].time == time else 0
            scans.append((clocks.seen(topic, time, message.header.stamp), Place(time, repeat)))
        elif topic == options.object_topic:
            objects.add(clocks.seen(topic, time, message.stamp), message.frame_id)
        elif topic == options.viewpoint_topic:
            viewpoints.add(clocks.seen(topic, time, message.stamp), message.frame_id)
        elif topic == options.joint_topic:
            joints = dict(zip(message.name, message.position.tolist(), strict=False))
            if joints.keys() >= next(iter(options.taught.values())).keys():
                name = standing_at(options.taught, joints, options.tolerance)
                viewpoints.add(clocks.seen(topic, time, message.header.stamp), name)
        else:
            static += [_plain(transform) for transform in message.transforms]
    clocks.check()
    if not scans:
        raise CellError(f"{bag.path} has no message on {options.scan_topic!r}, expected scans; record again")
    entries = [Entry(stamp, viewpoints.at(stamp), objects.at(stamp), place) for stamp, place in sorted(scans)]
    return Index(entries, objects, static)


def _viewpoint_topic(options: ReplayOptions) -> str:
    return options.joint_topic or options.viewpoint_topic


def _check_topics(bag: Bag, options: ReplayOptions) -> None:
    bag.require(options.scan_topic, "sensor_msgs/msg/PointCloud2")
    kind = "sensor_msgs/msg/JointState" if options.joint_topic else "std_msgs/msg/Header"
    bag.require(_viewpoint_topic(options), kind)
    if options.object_topic in bag.topics:
        bag.require(options.object_topic, "std_msgs/msg/Header")
    if options.pose_topic:
        bag.require(options.pose_topic, "geometry_msgs/msg/PoseStamped")


def _plain(message: Any) -> Transform:
    t, q = message.transform.translation, message.transform.rotation
    return message.header.frame_id, message.child_frame_id, [t.x, t.y, t.z], [q.x, q.y, q.z, q.w]
