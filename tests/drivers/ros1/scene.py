"""What peer and tests agree on."""

from beltsort.drivers.ros1 import Ros1ArmOptions, Ros1BeltOptions, Ros1CameraOptions, Ros1SorterOptions
from tests.drivers.ros.scenery import ACTION, CLOUDS, EMERGENCY, JOINTS, POINTS, POSES, TAUGHT

__all__ = ["POINTS", "POSES", "TAUGHT", "arm", "belt", "camera_by_joints", "camera_by_tf", "sorter"]

COMMAND = "/robot/limb/right/joint_command"


def camera_by_tf(master: str) -> Ros1CameraOptions:
    return Ros1CameraOptions(master=master, topic=CLOUDS, frame="optical", world_frame="world")


def camera_by_joints(master: str) -> Ros1CameraOptions:
    return Ros1CameraOptions(
        master=master, topic=CLOUDS, frame="optical", joint_topic=JOINTS, taught=TAUGHT, poses=POSES
    )


def arm(master: str, *, action: bool = False) -> Ros1ArmOptions:
    return Ros1ArmOptions(
        master=master,
        viewpoints=("p1", "p2"),
        taught=TAUGHT,
        joint_topic=JOINTS,
        joint_command_topic="" if action else COMMAND,
        action=ACTION if action else "",
        seconds=0.2,
        still=0.1,
        stalled=1.0,
        emergency_stop_topic=EMERGENCY,
    )


def belt(master: str) -> Ros1BeltOptions:
    return Ros1BeltOptions(master=master, emergency_stop_topic=EMERGENCY)


def sorter(master: str) -> Ros1SorterOptions:
    return Ros1SorterOptions(master=master, emergency_stop_topic=EMERGENCY)
