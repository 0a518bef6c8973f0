"""What of a ROS 1 system is the camera, the arm, the belt and the sorter."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from beltsort.drivers.ros.checks import check_pose, check_positive, check_taught
from beltsort.drivers.ros.joints import Joints
from beltsort.errors import CellError


@dataclass(frozen=True, kw_only=True)
class Ros1Options:
    """Where the ROS 1 system is.

    A ROS 1 master has no access control: keep it, and `address`, on the loopback or on a network of the
    cell's own.

    Attributes
    ----------
    master
        The master's URI (ROS_MASTER_URI).
    address
        This computer's address in the eyes of the other nodes (ROS_IP); on the loopback, nodes elsewhere
        cannot reach it.
    """

    master: str = "http://127.0.0.1:11311"
    address: str = "127.0.0.1"


@dataclass(frozen=True, kw_only=True)
class Ros1ActuatorOptions(Ros1Options):
    """What arm, belt and sorter have in common.

    Attributes
    ----------
    emergency_stop_topic
        std_msgs/Bool, latched or repeated: whether the emergency stop is pressed. Empty: nothing tells.
    """

    emergency_stop_topic: str = ""


@dataclass(frozen=True, kw_only=True)
class Ros1CameraOptions(Ros1Options):
    """A camera that publishes point clouds, and how its pose is known.

    Either by tf (`world_frame`), or by the joint states: at a taught viewpoint the camera has a known pose.
    By neither, it does not tell its pose, and a cell asks the arm.

    Attributes
    ----------
    topic
        sensor_msgs/PointCloud2, metres.
    frame
        The camera's optical frame, in which the clouds must be (x right, y down, z forward).
    world_frame
        tf's frame of the robot's world, in which the pose is told: the one on the belt surface under the belt
        end (`beltsort.geometry`), or that of which the cell file's `world_from_belt` speaks.
    pose_age
        How far from a cloud's stamp the pose that is taken may be, seconds.
    joint_topic
        sensor_msgs/JointState.
    taught
        Joint positions of each viewpoint, by its name and the joint's, radians.
    poses
        `world_from_camera` at each of these viewpoints in the robot's world, shape (4, 4).
    tolerance
        How far each joint may be from its taught position, radians.
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
        """Refuse a pose that two things tell, or half a thing does."""
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
class Ros1ArmOptions(Ros1ActuatorOptions):
    """An arm that reports its joints and takes joint positions.

    Attributes
    ----------
    viewpoints
        Their names, in the order of the model.
    taught
        Joint positions of each viewpoint, by its name and the joint's, radians.
    world_frame, flange_frame
        tf's frames of the robot's world and of the flange, for a camera that does not tell its pose; none if
        empty.
    pose_age
        How far from the newest joint states' stamp the flange's pose may be, seconds.
    joint_topic
        sensor_msgs/JointState.
    joint_command_topic
        Takes baxter_core_msgs/JointCommand in position mode, repeated while the arm moves.
    action
        Or: a control_msgs/FollowJointTrajectory action, by its namespace.
    seconds
        How long a motion by the action is to take.
    tolerance
        How far each joint may be from its target, radians.
    still
        For how long the joints must have stood still, seconds.
    stalled
        An arm that stands still elsewhere for so long, seconds, does not arrive.
    """

    viewpoints: tuple[str, ...]
    taught: Mapping[str, Joints]
    world_frame: str = ""
    flange_frame: str = ""
    pose_age: float = 0.2
    joint_topic: str = "/joint_states"
    joint_command_topic: str = ""
    action: str = ""
    seconds: float = 3.0
    tolerance: float = 0.02
    still: float = 0.2
    stalled: float = 2.0

    def __post_init__(self) -> None:
        """Refuse an arm that cannot be commanded, or not to every viewpoint."""
        if bool(self.joint_command_topic) == bool(self.action):
            raise CellError(
                f"joint_command_topic is {self.joint_command_topic!r} and action {self.action!r}; give the "
                "one that the arm listens to"
            )
        if bool(self.world_frame) != bool(self.flange_frame):
            raise CellError(
                f"world_frame is {self.world_frame!r} and flange_frame {self.flange_frame!r}; give both for "
                "the flange's pose by tf, or none"
            )
        check_positive(self, "seconds", "tolerance", "still", "stalled", "pose_age")
        check_taught(self.taught)
        if set(self.taught) != set(self.viewpoints) or not self.viewpoints:
            raise CellError(
                f"taught names {sorted(self.taught)}, expected joints for each of the viewpoints "
                f"{sorted(self.viewpoints)}; teach each"
            )


@dataclass(frozen=True, kw_only=True)
class Ros1BeltOptions(Ros1ActuatorOptions):
    """A belt that counts.

    Attributes
    ----------
    command_topic
        Takes std_msgs/Int32: the number of the object to bring to the belt end.
    state_topic
        std_msgs/Int32, at 5 Hz or more: the number of the object at the belt end while the belt stands,
        negative while it moves.
    stop_topic
        Takes std_msgs/Empty: stop now.
    """

    command_topic: str = "/belt/target"
    state_topic: str = "/belt/object"
    stop_topic: str = "/belt/stop"


@dataclass(frozen=True, kw_only=True)
class Ros1SorterOptions(Ros1ActuatorOptions):
    """A sorter that keeps a record of command ids.

    Attributes
    ----------
    command_topic
        Takes diagnostic_msgs/KeyValue: a key, on which it acts once, and the number of the bin.
    state_topic
        actionlib_msgs/GoalStatusArray, at 10 Hz or more: what became of each key that it remembers.
    stop_topic
        Takes std_msgs/Empty: stop now.
    """

    command_topic: str = "/sorter/command"
    state_topic: str = "/sorter/state"
    stop_topic: str = "/sorter/stop"

    def __post_init__(self) -> None:
        """Refuse a sorter that would hear itself."""
        topics = (self.command_topic, self.state_topic, self.stop_topic)
        if len({topic for topic in topics if topic}) < len(topics):
            raise CellError(
                f"command_topic, state_topic and stop_topic are {topics}, expected three different names; "
                "give each the sorter's own"
            )
