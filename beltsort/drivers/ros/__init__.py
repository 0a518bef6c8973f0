"""Contents of ROS messages, of ROS 1, ROS 2 and recordings: point clouds, frames, joint positions."""
