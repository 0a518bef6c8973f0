"""Topics that only the cell on ROS 2 has."""

DEPTH, INFO = "/camera/depth/image_rect", "/camera/depth/camera_info"
TRAJECTORY = "/arm_controller/joint_trajectory"
MOVE_GROUP, GROUP = "/move_action", "arm"
"""MoveIt's action, and its name of the arm's joints."""

ADVANCE_SERVICE, STOP_BELT_SERVICE, STOP_SORTER_SERVICE = "/belt/advance", "/belt/halt", "/sorter/halt"
BIN_SERVICES = {number: f"/sorter/bin_{number}" for number in range(5)}
COUNT = "/sorter/count"
"""The number of sorted objects."""
