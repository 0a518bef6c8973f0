"""The devices of a cell on ROS 2."""

from functools import partial

from beltsort.drivers.ros.arm import RosArm
from beltsort.drivers.ros.belt import RosBelt
from beltsort.drivers.ros.camera import RosCamera
from beltsort.drivers.ros.sorter import RosSorter
from beltsort.drivers.ros.sources import CloudSource, ImageSource
from beltsort.drivers.ros2.commanding import commanding
from beltsort.drivers.ros2.link import Ros2Link
from beltsort.drivers.ros2.options import (
    Ros2ArmOptions,
    Ros2BeltOptions,
    Ros2CameraOptions,
    Ros2SorterOptions,
)
from beltsort.drivers.ros2.status import REPORT


class Ros2Camera(RosCamera):
    """A camera on ROS 2: `RosCamera`, with its options."""

    def __init__(self, options: Ros2CameraOptions) -> None:
        images = options.depth_topic, options.info_topic
        source = ImageSource(*images) if options.depth_topic else CloudSource(options.topic)
        super().__init__(options, source, partial(Ros2Link, options))


class Ros2Arm(RosArm):
    """An arm on ROS 2: `RosArm`, with its options."""

    def __init__(self, options: Ros2ArmOptions) -> None:
        super().__init__(options, commanding(options), partial(Ros2Link, options))


class Ros2Belt(RosBelt):
    """A belt on ROS 2: `RosBelt`, with its options."""

    def __init__(self, options: Ros2BeltOptions) -> None:
        super().__init__(options, partial(Ros2Link, options))


class Ros2Sorter(RosSorter):
    """A sorter on ROS 2: `RosSorter`, with its options."""

    def __init__(self, options: Ros2SorterOptions) -> None:
        super().__init__(options, REPORT, partial(Ros2Link, options))
