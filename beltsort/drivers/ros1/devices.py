"""The devices of a cell on ROS 1."""

from functools import partial

from beltsort.drivers.ros.arm import RosArm
from beltsort.drivers.ros.belt import RosBelt
from beltsort.drivers.ros.camera import RosCamera
from beltsort.drivers.ros.sorter import RosSorter
from beltsort.drivers.ros.sources import CloudSource
from beltsort.drivers.ros1.commanding import commanding
from beltsort.drivers.ros1.link import Ros1Link
from beltsort.drivers.ros1.options import (
    Ros1ArmOptions,
    Ros1BeltOptions,
    Ros1CameraOptions,
    Ros1SorterOptions,
)
from beltsort.drivers.ros1.status import REPORT


class Ros1Camera(RosCamera):
    """A camera on ROS 1: `RosCamera`, with its options."""

    def __init__(self, options: Ros1CameraOptions) -> None:
        super().__init__(options, CloudSource(options.topic), partial(Ros1Link, options))


class Ros1Arm(RosArm):
    """An arm on ROS 1: `RosArm`, with its options."""

    def __init__(self, options: Ros1ArmOptions) -> None:
        super().__init__(options, commanding(options), partial(Ros1Link, options))


class Ros1Belt(RosBelt):
    """A belt on ROS 1: `RosBelt`, with its options."""

    def __init__(self, options: Ros1BeltOptions) -> None:
        super().__init__(options, partial(Ros1Link, options))


class Ros1Sorter(RosSorter):
    """A sorter on ROS 1: `RosSorter`, with its options."""

    def __init__(self, options: Ros1SorterOptions) -> None:
        super().__init__(options, REPORT, partial(Ros1Link, options))
