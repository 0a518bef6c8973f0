"""What an action of ROS 1 says of a goal."""

import pytest

from beltsort.cell import CommandError, Outcome
from beltsort.drivers.ros1 import Ros1Arm
from tests.drivers.ros.fixtures import an_id
from tests.drivers.ros1.rig import Rig

pytestmark = pytest.mark.process


def test_a_refused_goal_says_what_the_action_says(rig: Rig, acting_arm: Ros1Arm) -> None:
    acting_arm.move_to(1, an_id(), timeout=10.0)
    rig.tell(verdict=5)
    with pytest.raises(CommandError, match=r"\(5\).*says the peer") as error:
        acting_arm.move_to(0, an_id(), timeout=10.0)
    assert error.value.outcome is Outcome.NOT_DONE
