"""What peer and tests agree on."""

import numpy as np

from beltsort.drivers.ros1 import Ros1ArmOptions, Ros1BeltOptions, Ros1CameraOptions, Ros1SorterOptions

CLOUDS, JOINTS, COMMAND = "/camera/points", "/robot/joint_states", "/robot/limb/right/joint_command"
ACTION, BELT, SORTER, EMERGENCY = "/arm/follow_joint_trajectory", "/belt", "/sorter", "/emergency_stop"

TAUGHT = {"p1": {"shoulder": 0.3, "elbow": -0.2}, "p2": {"shoulder": -0.3, "elbow": 0.4}}
POSES = {"p1": np.diag([1.0, -1.0, -1.0, 1.0]).tolist(), "p2": np.diag([-1.0, 1.0, -1.0, 1.0]).tolist()}

POINTS = np.random.default_rng(8).uniform(-1.0, 1.0, (6, 8, 3)).astype(np.float32).astype(np.float64)
POINTS[2, 3] = np.nan


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
