"""Kinds of injected faults, and the calls that they affect."""

from enum import StrEnum

from beltsort.cell.wrappers.layer import METHODS

ACTS = tuple(METHODS.values())
COMMANDS = (*ACTS, "scan")


class Fault(StrEnum):
    """A kind of fault."""

    NOT_DONE = "not_done"
    """The device rejects the command; nothing is done."""
    LOST_ACKNOWLEDGEMENT = "lost_acknowledgement"
    """The command is done, but its reply is lost."""
    LATE = "late"
    """The call times out, and is executed afterwards."""
    STALE_SCAN = "stale_scan"
    """The scan is older than allowed."""
    EMPTY_SCAN = "empty_scan"
    """The scan has no points."""
    NAN_SCAN = "nan_scan"
    """All points of the scan are NaN."""
    TRUNCATED_SCAN = "truncated_scan"
    """The scan contains only the first third of its rows."""
    WRONG_ARRIVAL = "wrong_arrival"
    """The arm moves to another viewpoint and reports success."""
    FULL_BIN = "full_bin"
    """The bin is full; nothing is done."""
    EMERGENCY_STOP = "emergency_stop"
    """The emergency stop is pressed, and released after health has reported it once."""
    RESTART = "restart"
    """The controller restarts, before or after executing the call, and forgets all commands."""

    @property
    def affected(self) -> tuple[str, ...]:
        """Names of the calls that it can affect."""
        return AFFECTED.get(self, ACTS)


AFFECTED = {
    Fault.LATE: COMMANDS,
    Fault.WRONG_ARRIVAL: ("move_to",),
    Fault.FULL_BIN: ("sort",),
    Fault.EMERGENCY_STOP: COMMANDS,
    Fault.RESTART: COMMANDS,
    **dict.fromkeys((Fault.STALE_SCAN, Fault.EMPTY_SCAN, Fault.NAN_SCAN, Fault.TRUNCATED_SCAN), ("scan",)),
}
"""Calls that a fault can affect, where these are not the commands that move something (`ACTS`)."""
