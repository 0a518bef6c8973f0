"""Drivers for ROS 1: a camera, an arm commanded by joint positions, a belt and a sorter.

Needs rospy from Debian's packages, which runs in a process of its own, started when a device is first used.
`docs/ros.md` describes the interface.
"""

from beltsort.drivers.ros1.devices import Ros1Arm, Ros1Belt, Ros1Camera, Ros1Sorter
from beltsort.drivers.ros1.options import (
    Ros1ArmOptions,
    Ros1BeltOptions,
    Ros1CameraOptions,
    Ros1SorterOptions,
)

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
