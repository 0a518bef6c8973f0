"""Options of the devices on a ROS 2 system."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from beltsort.drivers.ros.checks import check_positive
from beltsort.drivers.ros.options import (
    ActuatorOptions,
    ArmOptions,
    BeltOptions,
    BeltStateOptions,
    CameraOptions,
    SorterOptions,
)
from beltsort.errors import CellError

RANGES = ("LOCALHOST", "SUBNET", "OFF", "SYSTEM_DEFAULT")
LARGEST_DOMAIN = 232


@dataclass(frozen=True, kw_only=True)
class Ros2Options:
    """The ROS 2 installation that is used, and the nodes that it finds.

    Whoever reaches the network of a ROS 2 system can command it, unless SROS 2 is used.

    Attributes
    ----------
    setup
        File that is sourced by bash before the node program starts, as "/opt/ros/jazzy/setup.bash". Empty if
        beltsort's own environment has ROS 2.
    python
        Interpreter of the node program, which has rclpy. Empty: python3 of the sourced environment, or
        without `setup` the Python of beltsort. In a cell file, a path with a slash starts at its folder.
    domain_id
        ROS_DOMAIN_ID; by default that of the environment.
    discovery_range
        ROS_AUTOMATIC_DISCOVERY_RANGE: "LOCALHOST" finds nodes of this computer, "SUBNET" those of the
        network, "OFF" those that the environment names, "SYSTEM_DEFAULT" what the middleware is configured
        for.
    """

    setup: str = ""
    python: str = ""
    domain_id: int | None = None
    discovery_range: str = "LOCALHOST"

    def __post_init__(self) -> None:
        """Check domain and range."""
        if self.domain_id is not None and not 0 <= self.domain_id <= LARGEST_DOMAIN:
            raise CellError(
                f"domain_id is {self.domain_id}, expected 0 to {LARGEST_DOMAIN}; give that of the other nodes"
            )
        if self.discovery_range not in RANGES:
            raise CellError(
                f"discovery_range is {self.discovery_range!r}, expected one of {', '.join(RANGES)}; "
                "LOCALHOST is for nodes of this computer, SUBNET for those of the network"
            )


@dataclass(frozen=True, kw_only=True)
class Ros2CameraOptions(CameraOptions, Ros2Options):
    """Options of a camera on ROS 2, also those of `CameraOptions` and `Ros2Options`.

    Attributes
    ----------
    topic
        sensor_msgs/PointCloud2, metres.
    depth_topic
        sensor_msgs/Image, an alternative to `topic`: rectified depth images, 16UC1 in millimetres or 32FC1 in
        metres.
    info_topic
        sensor_msgs/CameraInfo of the depth images.
    """

    topic: str = ""
    depth_topic: str = ""
    info_topic: str = ""

    def __post_init__(self) -> None:
        """Check that there is one source of scans, and all other options."""
        Ros2Options.__post_init__(self)
        if bool(self.topic) == bool(self.depth_topic) or bool(self.depth_topic) != bool(self.info_topic):
            raise CellError(
                f"topic is {self.topic!r}, depth_topic {self.depth_topic!r} and info_topic "
                f"{self.info_topic!r}; expected topic for clouds, or the other two for depth images; give "
                "either"
            )
        CameraOptions.__post_init__(self)


@dataclass(frozen=True, kw_only=True)
class Ros2ArmOptions(ArmOptions, Ros2Options):
    """Options of an arm on ROS 2, also those of `ArmOptions` and `Ros2Options`.

    Attributes
    ----------
    trajectory_topic
        trajectory_msgs/JointTrajectory, the topic of a joint_trajectory_controller; an alternative to
        `action`.
    move_action
        Namespace of a moveit_msgs/MoveGroup action, "/move_action" as MoveIt names it; an alternative to
        both. MoveIt plans the motions, which take as long as they need (`seconds` is not used).
    planning_group
        MoveIt's name of the group of joints; they must be those of `taught`, or include them.
    planning_seconds
        Time in which MoveIt must have planned a motion, seconds.
    velocity_scaling, acceleration_scaling
        Largest velocities and accelerations of the joints as fractions of those that MoveIt knows, above 0
        and at most 1.
    goal_tolerance
        Deviation of a joint from its target that MoveIt may plan, radians; below `tolerance`, within which
        the arm must stop.
    """

    trajectory_topic: str = ""
    move_action: str = ""
    planning_group: str = ""
    planning_seconds: float = 5.0
    velocity_scaling: float = 0.1
    acceleration_scaling: float = 0.1
    goal_tolerance: float = 0.001

    def __post_init__(self) -> None:
        """Check that the arm has one command interface, and joint positions for every viewpoint."""
        Ros2Options.__post_init__(self)
        if sum(map(bool, (self.trajectory_topic, self.action, self.move_action))) != 1:
            raise CellError(
                f"trajectory_topic is {self.trajectory_topic!r}, action {self.action!r} and move_action "
                f"{self.move_action!r}; expected one of them; give the interface of the arm's controller, or "
                "MoveIt's"
            )
        ArmOptions.__post_init__(self)
        self._check_planning()

    def _check_planning(self) -> None:
        """Check the options of MoveIt."""
        if bool(self.move_action) != bool(self.planning_group):
            raise CellError(
                f"move_action is {self.move_action!r} and planning_group {self.planning_group!r}; expected "
                "both for MoveIt, or none; give the other, or leave this one out"
            )
        check_positive(self, "planning_seconds", "velocity_scaling", "acceleration_scaling", "goal_tolerance")
        for name in ("velocity_scaling", "acceleration_scaling"):
            if getattr(self, name) > 1.0:
                raise CellError(
                    f"{name} is {getattr(self, name)}, expected at most 1, a fraction of the arm's largest; "
                    "start from the default"
                )
        if self.move_action and self.goal_tolerance >= self.tolerance:
            raise CellError(
                f"goal_tolerance is {self.goal_tolerance}, expected below tolerance, {self.tolerance}, so "
                "that what MoveIt plans is where the arm must stop; start from the default"
            )


@dataclass(frozen=True, kw_only=True)
class Ros2BeltOptions(BeltOptions, Ros2Options):
    """Options of a belt on ROS 2, those of `BeltOptions` and `Ros2Options`."""


@dataclass(frozen=True, kw_only=True)
class Ros2SorterOptions(SorterOptions, Ros2Options):
    """Options of a sorter on ROS 2, those of `SorterOptions` and `Ros2Options`."""

    def __post_init__(self) -> None:
        """Check all options."""
        Ros2Options.__post_init__(self)
        SorterOptions.__post_init__(self)


@dataclass(frozen=True, kw_only=True)
class Ros2DiverterOptions(Ros2Options):
    """Options of a belt that never stops on ROS 2, also those of `Ros2Options`.

    Attributes
    ----------
    request_topic
        Subscribed by the controller, std_msgs/Int64MultiArray: requests.
    reply_topic
        Published by the controller, std_msgs/Int64MultiArray: a reply to each request, of which the last is
        kept for those that subscribe later (transient local durability).
    answer_timeout
        Timeout of the acknowledgement of a request, seconds.
    """

    request_topic: str = "/diverter/request"
    reply_topic: str = "/diverter/reply"
    answer_timeout: float = 2.0

    def __post_init__(self) -> None:
        """Check that there are two topics, and all other options."""
        super().__post_init__()
        if not self.request_topic or not self.reply_topic or self.request_topic == self.reply_topic:
            raise CellError(
                f"request_topic is {self.request_topic!r} and reply_topic {self.reply_topic!r}, expected two "
                "different names; give the controller's"
            )
        check_positive(self, "answer_timeout")


@dataclass(frozen=True, kw_only=True)
class StopOptions:
    """How a device with services is told to stop; one of both.

    Attributes
    ----------
    stop_service
        std_srvs/Trigger: stop at once.
    stop_topic
        Subscribed by the device, std_msgs/Empty: stop at once.
    """

    stop_service: str = ""
    stop_topic: str = ""

    def __post_init__(self) -> None:
        """Check that there is one way to stop."""
        if bool(self.stop_service) == bool(self.stop_topic):
            raise CellError(
                f"stop_service is {self.stop_service!r} and stop_topic {self.stop_topic!r}; expected one of "
                "them, so that the device can be stopped; give the one that it has"
            )


@dataclass(frozen=True, kw_only=True)
class Ros2ServiceBeltOptions(BeltStateOptions, StopOptions, Ros2Options):
    """Options of a belt that is advanced by a service; also those of its base classes.

    Attributes
    ----------
    advance_service
        std_srvs/Trigger: advance by one object. It answers at once or when the belt has stopped; `success` is
        false only if the belt does not move.
    """

    advance_service: str

    def __post_init__(self) -> None:
        """Check all options."""
        Ros2Options.__post_init__(self)
        StopOptions.__post_init__(self)
        if not self.advance_service or not self.state_topic:
            raise CellError(
                f"advance_service is {self.advance_service!r} and state_topic {self.state_topic!r}, expected "
                "names: a belt that does not report the object at its end cannot be brought to another one "
                "by steps; give both"
            )
        if self.advance_service == self.stop_service:
            raise CellError(
                f"advance_service and stop_service are both {self.stop_service!r}, expected two services; "
                "give each the belt's own"
            )


@dataclass(frozen=True, kw_only=True)
class Ros2ServiceSorterOptions(ActuatorOptions, StopOptions, Ros2Options):
    """Options of a sorter with a service for each bin; also those of its base classes.

    Attributes
    ----------
    services
        std_srvs/Trigger by the number of the bin: put the object at the belt end into it. It answers when
        that is done; `success` is false only if nothing was moved.
    count_topic
        Published by the sorter, std_msgs/Int32, at 5 Hz or more: the number of objects that it has sorted
        since it was started, negative while it is not at rest. Empty if it publishes nothing.
    """

    services: Mapping[int, str] = field(default_factory=dict)
    count_topic: str = ""

    def __post_init__(self) -> None:
        """Check that every bin has a service of its own."""
        Ros2Options.__post_init__(self)
        StopOptions.__post_init__(self)
        names = [*self.services.values(), *([self.stop_service] if self.stop_service else [])]
        if not self.services or not all(names) or len(set(names)) < len(names):
            raise CellError(
                f"services is {dict(self.services)} and stop_service {self.stop_service!r}, expected a "
                "service for each bin, and none twice; give each the sorter's own"
            )
