"""What the peers on ROS 1 and ROS 2 and the tests agree on; needs NumPy only."""

import numpy as np

CLOUDS, JOINTS = "/camera/points", "/robot/joint_states"
ACTION, BELT, SORTER, EMERGENCY = "/arm/follow_joint_trajectory", "/belt", "/sorter", "/emergency_stop"

TAUGHT = {"p1": {"shoulder": 0.3, "elbow": -0.2}, "p2": {"shoulder": -0.3, "elbow": 0.4}}
POSES = {"p1": np.diag([1.0, -1.0, -1.0, 1.0]).tolist(), "p2": np.diag([-1.0, 1.0, -1.0, 1.0]).tolist()}

POINTS = np.random.default_rng(8).uniform(-1.0, 1.0, (6, 8, 3)).astype(np.float32).astype(np.float64)
POINTS[2, 3] = np.nan
