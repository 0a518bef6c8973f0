"""Topics that only the cell on ROS 2 has."""

DEPTH, INFO = "/camera/depth/image_rect", "/camera/depth/camera_info"
TRAJECTORY = "/arm_controller/joint_trajectory"
