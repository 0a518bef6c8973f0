"""Topics that only the cell on ROS 2 has."""

DEPTH, INFO = "/camera/depth/image_rect", "/camera/depth/camera_info"
TRAJECTORY = "/arm_controller/joint_trajectory"
MOVE_GROUP, GROUP = "/move_action", "arm"
"""MoveIt's action, and its name of the arm's joints."""
