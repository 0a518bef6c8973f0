"""Options of camera, arm, belt and sorter on a ROS 1 system."""

from dataclasses import dataclass

from beltsort.drivers.ros.options import ArmOptions, BeltOptions, CameraOptions, SorterOptions
from beltsort.errors import CellError


@dataclass(frozen=True, kw_only=True)
class Ros1Options:
    """Addresses of a ROS 1 system.

    A ROS 1 master has no access control: use the loopback interface or an isolated network.

    Attributes
    ----------
    master
        The master's URI (ROS_MASTER_URI).
    address
        Address of this computer for the other nodes (ROS_IP); with a loopback address, nodes on other
        computers cannot connect.
    """

    master: str = "http://127.0.0.1:11311"
    address: str = "127.0.0.1"


@dataclass(frozen=True, kw_only=True)
class Ros1CameraOptions(CameraOptions, Ros1Options):
    """Options of a camera on ROS 1, those of `CameraOptions` and `Ros1Options`."""


@dataclass(frozen=True, kw_only=True)
class Ros1ArmOptions(ArmOptions, Ros1Options):
    """Options of an arm on ROS 1, also those of `ArmOptions` and `Ros1Options`.

    Attributes
    ----------
    joint_command_topic
        baxter_core_msgs/JointCommand in position mode, repeated while the arm moves; an alternative to
        `action`.
    """

    joint_command_topic: str = ""

    def __post_init__(self) -> None:
        """Check that the arm has one command interface, and joint positions for every viewpoint."""
        if bool(self.joint_command_topic) == bool(self.action):
            raise CellError(
                f"joint_command_topic is {self.joint_command_topic!r} and action {self.action!r}; expected "
                "one of them; give the interface of the arm"
            )
        super().__post_init__()


@dataclass(frozen=True, kw_only=True)
class Ros1BeltOptions(BeltOptions, Ros1Options):
    """Options of a belt on ROS 1, those of `BeltOptions` and `Ros1Options`."""


@dataclass(frozen=True, kw_only=True)
class Ros1SorterOptions(SorterOptions, Ros1Options):
    """Options of a sorter on ROS 1, those of `SorterOptions` and `Ros1Options`."""
