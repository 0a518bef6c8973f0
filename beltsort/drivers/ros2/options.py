"""Options of camera, arm, belt and sorter on a ROS 2 system."""

from dataclasses import dataclass

from beltsort.drivers.ros.options import ArmOptions, BeltOptions, CameraOptions, SorterOptions
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
    """

    trajectory_topic: str = ""

    def __post_init__(self) -> None:
        """Check that the arm has one command interface, and joint positions for every viewpoint."""
        Ros2Options.__post_init__(self)
        if bool(self.trajectory_topic) == bool(self.action):
            raise CellError(
                f"trajectory_topic is {self.trajectory_topic!r} and action {self.action!r}; expected one of "
                "them; give the interface of the arm's controller"
            )
        ArmOptions.__post_init__(self)


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
