"""Topics that only the cell on ROS 2 has."""

TRAJECTORY = "/arm_controller/joint_trajectory"
