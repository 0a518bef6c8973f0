"""What ROS messages say, in ROS 1 and 2 and in recordings alike: point clouds, frames, joint positions."""
