"""A sorter's report of its keys as diagnostic_msgs/DiagnosticArray."""

from collections.abc import Mapping
from typing import Any

from beltsort.cell.commands import Outcome
from beltsort.drivers.ros.keys import KeyStatus, Report

STATE = "state"
"""Key of the value of a DiagnosticStatus that says what has become of a key."""

OUTCOMES = {
    "active": Outcome.RUNNING,
    "succeeded": Outcome.DONE,
    "rejected": Outcome.NOT_DONE,
    "aborted": Outcome.BROKEN_OFF,
}
"""What each state means; every other one means that the key's end is not known."""


def statuses(message: Mapping[str, Any]) -> dict[str, KeyStatus]:
    """Return the status of each key, which is the name of a DiagnosticStatus."""
    found = {}
    for entry in message["status"]:
        state = {pair["key"]: pair["value"] for pair in entry["values"]}.get(STATE, "")
        found[entry["name"]] = KeyStatus(OUTCOMES.get(state, Outcome.UNKNOWN), state, entry["message"])
    return found


REPORT = Report("diagnostic_msgs/DiagnosticArray", statuses)
