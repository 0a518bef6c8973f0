"""The kinds of faults, and what they befall."""

from enum import StrEnum

from beltsort.cell.wrappers.layer import METHODS

ACTS = tuple(METHODS.values())
COMMANDS = (*ACTS, "scan")


class Fault(StrEnum):
    """A way in which a command goes wrong."""

    NOT_DONE = "not_done"
    """The device refuses; nothing was done."""
    LOST_ACKNOWLEDGEMENT = "lost_acknowledgement"
    """It was done; the answer is lost."""
    LATE = "late"
    """It ends past its timeout: an act is still to come when the caller gives up."""
    STALE_SCAN = "stale_scan"
    """A scan older than it may be."""
    EMPTY_SCAN = "empty_scan"
    """A scan without points."""
    NAN_SCAN = "nan_scan"
    """A scan all of whose points are NaN."""
    TRUNCATED_SCAN = "truncated_scan"
    """The first third of a scan."""
    WRONG_ARRIVAL = "wrong_arrival"
    """The arm goes to another viewpoint and does not notice."""
    FULL_BIN = "full_bin"
    """The bin is full; nothing was done."""
    EMERGENCY_STOP = "emergency_stop"
    """Somebody presses the emergency stop, and releases it when health has reported it once."""
    RESTART = "restart"
    """The controller restarts, before or after the act, and forgets all commands."""

    @property
    def befalls(self) -> tuple[str, ...]:
        """The commands that it can befall."""
        return BEFALLS.get(self, ACTS)


BEFALLS = {
    Fault.LATE: COMMANDS,
    Fault.WRONG_ARRIVAL: ("move_to",),
    Fault.FULL_BIN: ("sort",),
    Fault.EMERGENCY_STOP: COMMANDS,
    Fault.RESTART: COMMANDS,
    **dict.fromkeys((Fault.STALE_SCAN, Fault.EMPTY_SCAN, Fault.NAN_SCAN, Fault.TRUNCATED_SCAN), ("scan",)),
}
"""Commands that a fault can befall, where these are not all that move something."""
