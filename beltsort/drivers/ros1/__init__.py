"""A cell on ROS 1: a camera that publishes clouds, an arm that takes joints, a belt that counts, a sorter.

Needs rospy of Debian's packages, which is loaded in a process of its own when a device is first used.
`docs/ros.md` tells how to set up a cell.
"""

from beltsort.drivers.ros1.arm import Ros1Arm
from beltsort.drivers.ros1.belt import Ros1Belt
from beltsort.drivers.ros1.camera import Ros1Camera
from beltsort.drivers.ros1.options import (
    Ros1ArmOptions,
    Ros1BeltOptions,
    Ros1CameraOptions,
    Ros1SorterOptions,
)
from beltsort.drivers.ros1.sorter import Ros1Sorter

__all__ = [
    "Ros1Arm",
    "Ros1ArmOptions",
    "Ros1Belt",
    "Ros1BeltOptions",
    "Ros1Camera",
    "Ros1CameraOptions",
    "Ros1Sorter",
    "Ros1SorterOptions",
]
