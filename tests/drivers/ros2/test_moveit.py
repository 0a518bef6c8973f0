"""An arm whose motions MoveIt plans."""

import dataclasses
from collections.abc import Iterator
from typing import Any

import pytest

from beltsort.cell import CommandError, Outcome
from beltsort.drivers.ros2 import Ros2Arm
from beltsort.errors import CellError
from tests.drivers.ros.fixtures import an_id
from tests.drivers.ros.rig import await_ready
from tests.drivers.ros2 import scene
from tests.drivers.ros2.rig import Rig
from tests.waiting import wait_until

pytestmark = pytest.mark.process


@pytest.fixture(scope="module")
def shared_planned_arm(shared: Rig) -> Iterator[Ros2Arm]:
    with Ros2Arm(scene.arm_by_moveit(shared.domain)) as arm:
        yield arm


@pytest.fixture
def arm(rig: Rig, shared_planned_arm: Ros2Arm) -> Ros2Arm:
    await_ready(shared_planned_arm)
    return shared_planned_arm


def test_it_may_plan_for_longer_than_an_arm_may_stand_still(rig: Rig, arm: Ros2Arm) -> None:
    arm.move_to(0, an_id(), timeout=30.0)
    rig.tell(plan=1.5)  # `stalled` is 1 s, and `planning_seconds` 1 s more
    one = an_id()
    arm.move_to(1, one, timeout=30.0)
    assert arm.outcome_of(one) is Outcome.DONE


@pytest.mark.parametrize(
    ("verdict", "said"),
    [(5, r"\bhas rejected the goal\b"), (4, r"\bwas aborted \(GOAL_IN_COLLISION\) says the peer\b")],
)
def test_a_goal_that_fails_says_why(rig: Rig, arm: Ros2Arm, verdict: int, said: str) -> None:
    arm.move_to(1, an_id(), timeout=30.0)
    rig.tell(verdict=verdict)
    with pytest.raises(CommandError, match=said) as error:
        arm.move_to(0, an_id(), timeout=30.0)
    assert error.value.outcome is Outcome.NOT_DONE


def test_a_group_that_moveit_does_not_know(rig: Rig) -> None:
    options = dataclasses.replace(scene.arm_by_moveit(rig.domain), planning_group="legs")
    with Ros2Arm(options) as arm, pytest.raises(CommandError, match=r"\(INVALID_GROUP_NAME\)") as error:
        arm.move_to(0 if rig.tell()["joints"]["elbow"] > 0.0 else 1, an_id(), timeout=30.0)
    assert error.value.outcome is Outcome.NOT_DONE


def test_a_stop_cancels_the_goal(rig: Rig, arm: Ros2Arm) -> None:
    arm.move_to(0, an_id(), timeout=30.0)
    rig.tell(speed=0.1)
    one = an_id()
    stopping = rig.when_busy("arm", arm.stop)
    with pytest.raises(CommandError, match=r"\bstop\b.*'p2'") as error:
        arm.move_to(1, one, timeout=30.0)
    assert error.value.outcome is Outcome.UNKNOWN
    stopping.join()
    wait_until(lambda: not rig.tell()["busy"]["arm"], "the arm stands still")
    rig.mend()
    assert arm.outcome_of(one) is not Outcome.DONE
    assert arm.move_to(1, one, timeout=30.0) > 0.0


def test_a_move_whose_result_was_lost_is_looked_up(rig: Rig, arm: Ros2Arm) -> None:
    """The node that would receive the result is gone, and the action's status topic keeps the status."""
    arm.move_to(0, an_id(), timeout=30.0)
    rig.tell(speed=0.3)
    one = an_id()
    interrupting = rig.when_busy("arm", arm.close)
    with pytest.raises(CommandError) as error:
        arm.move_to(1, one, timeout=30.0)
    assert error.value.outcome is Outcome.UNKNOWN
    interrupting.join()
    wait_until(lambda: not rig.tell()["busy"]["arm"], "the arm stands still")
    assert arm.outcome_of(one) is Outcome.DONE


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"action": "/arm"}, r"\baction '/arm' and move_action '/move_action'; expected one\b"),
        ({"planning_group": ""}, r"\bmove_action is '/move_action' and planning_group ''; expected both\b"),
        ({"velocity_scaling": 1.5}, r"\bvelocity_scaling is 1\.5, expected at most 1\b"),
        ({"acceleration_scaling": 0.0}, r"\bacceleration_scaling is 0\.0, expected above 0\b"),
        ({"goal_tolerance": 0.02}, r"\bgoal_tolerance is 0\.02, expected below tolerance, 0\.02\b"),
    ],
)
def test_options_that_do_not_fit(changes: dict[str, Any], said: str) -> None:
    with pytest.raises(CellError, match=said):
        dataclasses.replace(scene.arm_by_moveit(1), **changes)
