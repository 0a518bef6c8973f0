"""Drivers for ROS 2: camera, arm commanded by joint positions, belt and sorter, belt that never stops.

Needs rclpy and messages of any ROS 2 distribution, which run in a process of their own, started when a
device is first used. `docs/ros.md` describes the interface.
"""

from beltsort.drivers.ros2.devices import Ros2Arm, Ros2Belt, Ros2Camera, Ros2Sorter
from beltsort.drivers.ros2.diverter import Ros2Diverter
from beltsort.drivers.ros2.options import (
    Ros2ArmOptions,
    Ros2BeltOptions,
    Ros2CameraOptions,
    Ros2DiverterOptions,
    Ros2ServiceBeltOptions,
    Ros2ServiceSorterOptions,
    Ros2SorterOptions,
)
from beltsort.drivers.ros2.service_belt import Ros2ServiceBelt
from beltsort.drivers.ros2.service_sorter import Ros2ServiceSorter

__all__ = [
    "Ros2Arm",
    "Ros2ArmOptions",
    "Ros2Belt",
    "Ros2BeltOptions",
    "Ros2Camera",
    "Ros2CameraOptions",
    "Ros2Diverter",
    "Ros2DiverterOptions",
    "Ros2ServiceBelt",
    "Ros2ServiceBeltOptions",
    "Ros2ServiceSorter",
    "Ros2ServiceSorterOptions",
    "Ros2Sorter",
    "Ros2SorterOptions",
]
