"""The numbers of actionlib_msgs/GoalStatus, and a sorter's report of them."""

from collections.abc import Mapping
from typing import Any

from beltsort.cell.commands import Outcome
from beltsort.drivers.ros.keys import KeyStatus, Report

RUNNING = (0, 1, 6, 7)
"""Pending, active, preempting, recalling."""
SUCCEEDED = 3
REFUSED = (5, 8)
"""Rejected, recalled: nothing moved."""


def statuses(message: Mapping[str, Any]) -> dict[str, KeyStatus]:
    """Return the status of each goal by its id."""
    return {
        entry["goal_id"]["id"]: KeyStatus(_outcome(entry["status"]), str(entry["status"]), entry["text"])
        for entry in message["status_list"]
    }


def _outcome(status: int) -> Outcome:
    if status == SUCCEEDED:
        return Outcome.DONE
    if status in RUNNING:
        return Outcome.RUNNING
    return Outcome.NOT_DONE if status in REFUSED else Outcome.BROKEN_OFF


REPORT = Report("actionlib_msgs/GoalStatusArray", statuses)
