"""Devices of real cells: over a fieldbus, over ROS, and played back from recordings."""
