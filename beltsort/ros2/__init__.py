"""A run as a node of ROS 2: topics of its state, and a lifecycle by which it is held and continued.

`beltsort.ros2.node` is the node program; it runs in a process of its own, with a Python that has rclpy.
docs/ros.md describes topics, lifecycle and parameters.
"""
