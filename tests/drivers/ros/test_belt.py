"""A belt on ROS."""

import pytest

from beltsort.cell import CommandError, Outcome
from beltsort.drivers.ros.belt import RosBelt
from tests.drivers.ros.fixtures import an_id
from tests.drivers.ros.rig import PeerRig
from tests.waiting import wait_until

pytestmark = pytest.mark.process


def test_it_advances_forward_only_and_a_repeated_command_acts_once(rig: PeerRig, belt: RosBelt) -> None:
    n, one = rig.tell()["object"] + 1, an_id()
    stop = belt.advance_to(n, one, timeout=10.0)
    assert belt.advance_to(n, one) == stop
    assert belt.advance_to(n + 1, f"{one}-next", timeout=10.0) > stop
    assert belt.advance_to(n + 1, f"{one}-same", timeout=10.0) > stop
    assert belt.outcome_of(f"{one}-next") is Outcome.DONE
    with pytest.raises(CommandError, match=rf"\bindex\b.*\b{n}\b.*\b{n + 1}\b") as error:
        belt.advance_to(n, f"{one}-back", timeout=10.0)
    assert error.value.outcome is belt.outcome_of(f"{one}-back") is Outcome.NOT_DONE
    assert belt.outcome_of("of another process") is Outcome.UNKNOWN
    assert belt.health().ready


def test_a_stopped_belt_does_not_arrive(rig: PeerRig, belt: RosBelt) -> None:
    n, one = rig.tell()["object"] + 1, an_id()
    rig.tell(travel=60.0)
    with pytest.raises(CommandError, match=rf"-1\b.*\b{n}\b.*\b2 s\b"):
        belt.advance_to(n, one, timeout=2.0)
    belt.stop()
    wait_until(lambda: rig.tell()["halted"], "the belt is told to stop")
    assert belt.outcome_of(one) is Outcome.UNKNOWN
    rig.mend()
    assert belt.advance_to(n, one, timeout=10.0) > 0.0
