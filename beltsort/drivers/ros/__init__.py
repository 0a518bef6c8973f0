"""What ROS 1, ROS 2 and recordings share: contents of messages, and the devices of a running cell."""
