"""The numbers of actionlib_msgs/GoalStatus."""

RUNNING = (0, 1, 6, 7)
"""Pending, active, preempting, recalling."""
SUCCEEDED = 3
REFUSED = (5, 8)
"""Rejected, recalled: nothing moved."""
