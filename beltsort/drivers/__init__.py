"""Drivers for real devices: over a fieldbus, over ROS 1, and playback of recordings."""
