"""How long a run may be silent before a service manager should take it for hung."""

from beltsort.cellfile.description import CellDescription

ALLOWANCE = 60.0
"""Time for planning, perception, short questions to devices and a busy disk within one step, seconds."""


def longest_step(description: CellDescription) -> float:
    """Return the longest time between two signs of life of a run, seconds, if devices keep to their timeouts.

    A run gives a sign before each step, before each further attempt at a command, and all the time while it
    is held. So in between is one command that fails only at its timeout and is then inquired about, or the
    scans of one step, all of which fail only at theirs.
    """
    timeouts, rules = description.timeouts, description.rules
    command = 2.0 * max(timeouts.move, timeouts.sort, timeouts.advance)
    scans = rules.scan_attempts * timeouts.scan
    return ALLOWANCE + (description.planner.seconds or 0.0) + max(command, scans)
