"""Options of camera, arm, belt and sorter that ROS 1 and ROS 2 share."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from beltsort.drivers.ros.checks import check_pose, check_positive, check_taught
from beltsort.drivers.ros.joints import Joints
from beltsort.errors import CellError


@dataclass(frozen=True, kw_only=True)
class ActuatorOptions:
    """Options of arm, belt and sorter.

    Attributes
    ----------
    emergency_stop_topic
        std_msgs/Bool, latched or repeated: whether the emergency stop is pressed. Empty if there is none.
    """

    emergency_stop_topic: str = ""


@dataclass(frozen=True, kw_only=True)
class CameraOptions:
    """Options of a camera that publishes point clouds.

    Its pose comes from tf (`world_frame`), or from the joint states (`taught` and `poses`). With neither, the
    camera does not report its pose, and the cell uses that of the arm.

    Attributes
    ----------
    topic
        sensor_msgs/PointCloud2, metres.
    frame
        The camera's optical frame, in which the clouds must be (x right, y down, z forward).
    world_frame
        tf's name of the robot's world frame: the belt frame (`beltsort.geometry`), or the frame to which the
        cell file's `world_from_belt` refers.
    pose_age
        Largest difference between the stamps of a cloud and of its pose, seconds.
    joint_topic
        sensor_msgs/JointState.
    taught
        Joint positions of each viewpoint, by its name and the joint's, radians.
    poses
        `world_from_camera` at each of these viewpoints in the robot's world, shape (4, 4).
    tolerance
        Largest deviation of a joint from its taught position, radians.
    """

    topic: str
    frame: str
    world_frame: str = ""
    pose_age: float = 0.2
    joint_topic: str = ""
    taught: Mapping[str, Joints] = field(default_factory=dict)
    poses: Mapping[str, Sequence[Sequence[float]]] = field(default_factory=dict)
    tolerance: float = 0.02

    def __post_init__(self) -> None:
        """Check that the pose has at most one source, with all its options."""
        by_joints = [bool(self.joint_topic), bool(self.taught), bool(self.poses)]
        if any(by_joints) and (self.world_frame or not all(by_joints)):
            raise CellError(
                f"world_frame is {self.world_frame!r}, joint_topic {self.joint_topic!r}, taught names "
                f"{sorted(self.taught)} and poses {sorted(self.poses)}; give either world_frame or the other "
                "three, or none of them"
            )
        if set(self.poses) != set(self.taught):
            raise CellError(
                f"poses names {sorted(self.poses)}, expected the viewpoints of taught, "
                f"{sorted(self.taught)}; give the camera's pose at each"
            )
        check_positive(self, "pose_age", "tolerance")
        check_taught(self.taught)
        for name, rows in self.poses.items():
            check_pose(f"poses.{name}", rows)


@dataclass(frozen=True, kw_only=True)
class ArmOptions(ActuatorOptions):
    """Options of an arm that publishes joint states and is commanded by joint positions.

    Attributes
    ----------
    viewpoints
        Names of the viewpoints, in the order of the model.
    taught
        Joint positions of each viewpoint, by its name and the joint's, radians.
    world_frame, flange_frame
        tf's names of the robot's world frame and of the flange's frame, for a camera that does not report its
        pose; empty if not used.
    pose_age
        Largest difference between the stamps of the newest joint states and of the flange's pose, seconds.
    joint_topic
        sensor_msgs/JointState.
    action
        Namespace of a control_msgs/FollowJointTrajectory action; empty if not used.
    seconds
        Duration of a motion by a trajectory, seconds.
    tolerance
        Largest deviation of a joint from its target, radians.
    still
        Time for which the joints must stand still at the target to have arrived, seconds.
    stalled
        Time after which an arm that stands still elsewhere is considered not to arrive, seconds.
    """

    viewpoints: tuple[str, ...]
    taught: Mapping[str, Joints]
    world_frame: str = ""
    flange_frame: str = ""
    pose_age: float = 0.2
    joint_topic: str = "/joint_states"
    action: str = ""
    seconds: float = 3.0
    tolerance: float = 0.02
    still: float = 0.2
    stalled: float = 2.0

    def __post_init__(self) -> None:
        """Check that there are joint positions for every viewpoint."""
        if bool(self.world_frame) != bool(self.flange_frame):
            raise CellError(
                f"world_frame is {self.world_frame!r} and flange_frame {self.flange_frame!r}; expected both "
                "for the flange's pose from tf, or none; give the other, or leave this one out"
            )
        check_positive(self, "seconds", "tolerance", "still", "stalled", "pose_age")
        check_taught(self.taught)
        if set(self.taught) != set(self.viewpoints) or not self.viewpoints:
            raise CellError(
                f"taught names {sorted(self.taught)}, expected joints for each of the viewpoints "
                f"{sorted(self.viewpoints)}; teach each"
            )


@dataclass(frozen=True, kw_only=True)
class BeltStateOptions(ActuatorOptions):
    """Options of a belt that reports the number of the object at its end, however it is commanded.

    Attributes
    ----------
    state_topic
        Published by the belt, std_msgs/Int32, at 5 Hz or more: the number of the object at the belt end while
        the belt stands, negative while it moves.
    """

    state_topic: str = "/belt/object"


@dataclass(frozen=True, kw_only=True)
class BeltOptions(BeltStateOptions):
    """Options of a belt that is commanded by the number of an object, also those of `BeltStateOptions`.

    Attributes
    ----------
    command_topic
        Subscribed by the belt, std_msgs/Int32: the number of the object to bring to the belt end.
    stop_topic
        Subscribed by the belt, std_msgs/Empty: stop at once.
    """

    command_topic: str = "/belt/target"
    stop_topic: str = "/belt/stop"


@dataclass(frozen=True, kw_only=True)
class SorterOptions(ActuatorOptions):
    """Options of a sorter that remembers keys of commands.

    Attributes
    ----------
    command_topic
        Subscribed by the sorter, diagnostic_msgs/KeyValue: a key, which is executed once, and the number of
        the bin.
    state_topic
        Published by the sorter at 10 Hz or more: the status of each key that it remembers, as
        actionlib_msgs/GoalStatusArray on ROS 1 and diagnostic_msgs/DiagnosticArray on ROS 2.
    stop_topic
        Subscribed by the sorter, std_msgs/Empty: stop at once.
    """

    command_topic: str = "/sorter/command"
    state_topic: str = "/sorter/state"
    stop_topic: str = "/sorter/stop"

    def __post_init__(self) -> None:
        """Check that the topics differ."""
        topics = (self.command_topic, self.state_topic, self.stop_topic)
        if len({topic for topic in topics if topic}) < len(topics):
            raise CellError(
                f"command_topic, state_topic and stop_topic are {topics}, expected three different names; "
                "give each the sorter's own"
            )
