"""How long a run may be silent before a service manager should take it for hung."""

from beltsort.cellfile.description import CellDescription
from beltsort.cellfile.moving import Moving
from beltsort.sorting.moving.diverting import ASKED_AT_ONCE

QUESTIONS = ASKED_AT_ONCE + 4
"""Questions to a belt that never stops in one step: diversions, and readings of its encoder."""

ALLOWANCE = 60.0
"""Time for planning, perception, short questions to devices and a busy disk within one step, seconds."""


def longest_step(description: CellDescription) -> float:
    """Return the longest time between two signs of life of a run, seconds, if devices keep to their timeouts.

    A run gives a sign before each step, before each further attempt at a command, and all the time while it
    is held. So in between is one command that fails only at its timeout and is then inquired about, or the
    scans of one step, all of which fail only at theirs. On a belt that never stops it is a step of the loop:
    its questions to the belt, a move, and a scan that is taken no earlier than planned.
    """
    timeouts, rules = description.timeouts, description.rules
    if description.moving is not None:
        return ALLOWANCE + (description.planner.seconds or 0.0) + _longest_on(description, description.moving)
    command = 2.0 * max(timeouts.move, timeouts.sort, timeouts.advance)
    scans = rules.scan_attempts * timeouts.scan
    return ALLOWANCE + (description.planner.seconds or 0.0) + max(command, scans)


def _longest_on(description: CellDescription, moving: Moving) -> float:
    timeouts, moves = description.timeouts, moving.move_ticks
    move = moves if isinstance(moves, int) else max(map(max, moves))
    waiting = max(1, move + moving.scan_ticks) * moving.seconds_per_tick
    return QUESTIONS * timeouts.divert + timeouts.move + timeouts.scan + waiting
