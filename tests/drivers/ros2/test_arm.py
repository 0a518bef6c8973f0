"""What an action of ROS 2 says of a goal, and keeps."""

import pytest

from beltsort.cell import CommandError, Outcome
from beltsort.drivers.ros2 import Ros2Arm
from tests.drivers.ros.fixtures import an_id
from tests.drivers.ros2.rig import Rig
from tests.waiting import wait_until

pytestmark = pytest.mark.process


@pytest.mark.parametrize(
    ("verdict", "said"), [(5, r"\bhas rejected the goal\b"), (4, r"\bwas aborted says the peer\b")]
)
def test_a_goal_that_fails_says_what_the_action_says(
    rig: Rig, acting_arm: Ros2Arm, verdict: int, said: str
) -> None:
    acting_arm.move_to(1, an_id(), timeout=10.0)
    rig.tell(verdict=verdict)
    with pytest.raises(CommandError, match=said) as error:
        acting_arm.move_to(0, an_id(), timeout=10.0)
    assert error.value.outcome is Outcome.NOT_DONE


def test_a_move_whose_result_was_lost_is_looked_up(rig: Rig, acting_arm: Ros2Arm) -> None:
    """The node that would receive the result is gone, and the action's status topic keeps the status."""
    acting_arm.move_to(0, an_id(), timeout=10.0)
    rig.tell(speed=0.3)
    one = an_id()

    def interrupt() -> None:
        acting_arm.close()
        rig.tell(offset=0.0)

    interrupting = rig.when_busy("arm", interrupt)
    with pytest.raises(CommandError) as error:
        acting_arm.move_to(1, one, timeout=10.0)
    assert error.value.outcome is Outcome.UNKNOWN
    interrupting.join()
    wait_until(lambda: not rig.tell()["busy"]["arm"], "the arm stands still")
    assert acting_arm.outcome_of(one) is Outcome.DONE
