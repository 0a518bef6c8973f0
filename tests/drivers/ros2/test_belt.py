"""A belt on ROS 2."""

from itertools import count

import pytest

from beltsort.cell import CommandError, Outcome
from beltsort.drivers.ros2 import Ros2Belt
from tests.drivers.ros2.rig import Rig
from tests.waiting import wait_until

pytestmark = pytest.mark.process

OBJECTS = count(10, 10)
"""The belt of all tests moves forward only."""


def test_it_advances_forward_only_and_a_repeated_command_acts_once(belt: Ros2Belt) -> None:
    n = next(OBJECTS)
    stop = belt.advance_to(n, f"{n}", timeout=10.0)
    assert belt.advance_to(n, f"{n}") == stop
    assert belt.advance_to(n + 1, f"{n}-next", timeout=10.0) > stop
    assert belt.advance_to(n + 1, f"{n}-same", timeout=10.0) > stop
    assert belt.outcome_of(f"{n}-next") is Outcome.DONE
    with pytest.raises(CommandError, match=rf"\bindex\b.*\b{n}\b.*\b{n + 1}\b") as error:
        belt.advance_to(n, f"{n}-back", timeout=10.0)
    assert error.value.outcome is belt.outcome_of(f"{n}-back") is Outcome.NOT_DONE
    assert belt.outcome_of("of another process") is Outcome.UNKNOWN
    assert belt.health().ready


def test_a_stopped_belt_does_not_arrive(rig: Rig, belt: Ros2Belt) -> None:
    n = next(OBJECTS)
    rig.tell(travel=60.0)
    with pytest.raises(CommandError, match=rf"-1\b.*\b{n}\b.*\b2 s\b"):
        belt.advance_to(n, f"{n}", timeout=2.0)
    belt.stop()
    wait_until(lambda: rig.tell()["halted"], "the belt is told to stop")
    assert belt.outcome_of(f"{n}") is Outcome.UNKNOWN
    rig.mend()
    assert belt.advance_to(n, f"{n}", timeout=10.0) > 0.0
