"""Options of the devices on ROS 2 that the tests use."""

import dataclasses
import sys
from pathlib import Path

from beltsort.drivers.ros2 import (
    Ros2ArmOptions,
    Ros2BeltOptions,
    Ros2CameraOptions,
    Ros2ServiceBeltOptions,
    Ros2ServiceSorterOptions,
    Ros2SorterOptions,
)
from tests.drivers.ros.scenery import ACTION, CLOUDS, EMERGENCY, JOINTS, POINTS, POSES, TAUGHT
from tests.drivers.ros2.topics import (
    ADVANCE_SERVICE,
    BIN_SERVICES,
    COUNT,
    GROUP,
    MOVE_GROUP,
    STOP_BELT_SERVICE,
    STOP_SORTER_SERVICE,
    TRAJECTORY,
)

__all__ = [
    "POINTS",
    "POSES",
    "PYTHON",
    "TAUGHT",
    "arm",
    "arm_by_moveit",
    "belt",
    "belt_by_service",
    "camera_by_joints",
    "camera_by_tf",
    "sorter",
    "sorter_by_service",
]

PYTHON = str(Path(sys.prefix) / "ros2" / "bin" / "python")
"""The interpreter of the environment that scripts/bootstrap makes for tests of ROS 2."""


def camera_by_tf(domain: int) -> Ros2CameraOptions:
    return Ros2CameraOptions(
        python=PYTHON, domain_id=domain, topic=CLOUDS, frame="optical", world_frame="world"
    )


def camera_by_joints(domain: int) -> Ros2CameraOptions:
    return Ros2CameraOptions(
        python=PYTHON,
        domain_id=domain,
        topic=CLOUDS,
        frame="optical",
        joint_topic=JOINTS,
        taught=TAUGHT,
        poses=POSES,
    )


def arm(domain: int, *, action: bool = False) -> Ros2ArmOptions:
    return Ros2ArmOptions(
        python=PYTHON,
        domain_id=domain,
        viewpoints=("p1", "p2"),
        taught=TAUGHT,
        joint_topic=JOINTS,
        trajectory_topic="" if action else TRAJECTORY,
        action=ACTION if action else "",
        seconds=0.2,
        still=0.1,
        stalled=1.0,
        emergency_stop_topic=EMERGENCY,
    )


def arm_by_moveit(domain: int) -> Ros2ArmOptions:
    return dataclasses.replace(
        arm(domain),
        trajectory_topic="",
        move_action=MOVE_GROUP,
        planning_group=GROUP,
        planning_seconds=1.0,
    )


def belt(domain: int) -> Ros2BeltOptions:
    return Ros2BeltOptions(python=PYTHON, domain_id=domain, emergency_stop_topic=EMERGENCY)


def sorter(domain: int) -> Ros2SorterOptions:
    return Ros2SorterOptions(python=PYTHON, domain_id=domain, emergency_stop_topic=EMERGENCY)


def belt_by_service(domain: int) -> Ros2ServiceBeltOptions:
    return Ros2ServiceBeltOptions(
        python=PYTHON,
        domain_id=domain,
        advance_service=ADVANCE_SERVICE,
        stop_service=STOP_BELT_SERVICE,
        emergency_stop_topic=EMERGENCY,
    )


def sorter_by_service(domain: int, *, counts: bool = True) -> Ros2ServiceSorterOptions:
    return Ros2ServiceSorterOptions(
        python=PYTHON,
        domain_id=domain,
        services=BIN_SERVICES,
        count_topic=COUNT if counts else "",
        stop_service=STOP_SORTER_SERVICE,
        emergency_stop_topic=EMERGENCY,
    )
