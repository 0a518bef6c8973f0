"""An arm on ROS 2, by the topic of a controller and by an action."""

import dataclasses
import time
from collections.abc import Iterator
from uuid import uuid4

import pytest

from beltsort.cell import CommandError, Outcome
from beltsort.drivers.ros2 import Ros2Arm
from tests.drivers.ros2 import scene
from tests.drivers.ros2.rig import Rig
from tests.waiting import wait_until

pytestmark = pytest.mark.process


@pytest.fixture(scope="package")
def shared_acting_arm(shared: Rig) -> Iterator[Ros2Arm]:
    with Ros2Arm(scene.arm(shared.domain, action=True)) as arm:
        yield arm


@pytest.fixture(params=["topic", "action"])
def either(
    rig: Rig, shared_arm: Ros2Arm, shared_acting_arm: Ros2Arm, request: pytest.FixtureRequest
) -> Ros2Arm:
    return shared_acting_arm if request.param == "action" else shared_arm


def an_id() -> str:
    return uuid4().hex


def test_it_moves_and_tells_when_it_stopped(either: Ros2Arm) -> None:
    for viewpoint in (0, 1):
        began, one = time.monotonic(), an_id()
        stop = either.move_to(viewpoint, one, timeout=10.0)
        assert began < stop <= time.monotonic()
        assert either.outcome_of(one) is Outcome.DONE


def test_the_flange_is_where_tf_says(rig: Rig, arm: Ros2Arm) -> None:
    assert arm.flange_pose() is None, "no frame is named"
    options = dataclasses.replace(scene.arm(rig.domain), world_frame="world", flange_frame="optical")
    with Ros2Arm(options) as telling:
        telling.move_to(1, an_id(), timeout=10.0)
        pose = telling.flange_pose(timeout=10.0)
        assert pose is not None
        assert pose[2, 3] == pytest.approx(scene.TAUGHT["p2"]["elbow"], abs=options.tolerance)
    said = r"pose of 'hand'.*\b1 s\b.*\btransforms\b.*'hand'.*'world'"
    with Ros2Arm(dataclasses.replace(options, flange_frame="hand")) as lost:
        wait_until(lambda: lost.health().ready, "the nodes find each other")
        with pytest.raises(CommandError, match=said):
            lost.flange_pose(timeout=1.0)


@pytest.mark.parametrize(
    ("verdict", "said"), [(5, r"\bhas rejected the goal\b"), (4, r"\bwas aborted says the peer\b")]
)
def test_a_goal_that_fails_says_what_the_action_says(
    rig: Rig, shared_acting_arm: Ros2Arm, verdict: int, said: str
) -> None:
    shared_acting_arm.move_to(1, an_id(), timeout=10.0)
    rig.tell(verdict=verdict)
    with pytest.raises(CommandError, match=said) as error:
        shared_acting_arm.move_to(0, an_id(), timeout=10.0)
    assert error.value.outcome is Outcome.NOT_DONE


def test_a_stop_from_another_thread_ends_the_motion(rig: Rig, either: Ros2Arm) -> None:
    either.move_to(0, an_id(), timeout=10.0)
    rig.tell(speed=0.1)
    one = an_id()
    stopping = rig.when_busy("arm", either.stop)
    with pytest.raises(CommandError, match=r"\bstop\b.*'p2'") as error:
        either.move_to(1, one, timeout=10.0)
    assert error.value.outcome is Outcome.UNKNOWN
    stopping.join()
    wait_until(lambda: not rig.tell()["busy"]["arm"], "the arm stands still")
    rig.mend()
    assert either.outcome_of(one) is not Outcome.DONE
    assert either.move_to(1, one, timeout=10.0) > 0.0


def test_a_move_whose_result_was_lost_is_looked_up(rig: Rig, shared_acting_arm: Ros2Arm) -> None:
    """The node that would receive the result is gone, and the action's status topic keeps the status."""
    shared_acting_arm.move_to(0, an_id(), timeout=10.0)
    rig.tell(speed=0.3)
    one = an_id()

    def interrupt() -> None:
        shared_acting_arm.close()
        rig.tell(offset=0.0)

    interrupting = rig.when_busy("arm", interrupt)
    with pytest.raises(CommandError) as error:
        shared_acting_arm.move_to(1, one, timeout=10.0)
    assert error.value.outcome is Outcome.UNKNOWN
    interrupting.join()
    wait_until(lambda: not rig.tell()["busy"]["arm"], "the arm stands still")
    assert shared_acting_arm.outcome_of(one) is Outcome.DONE
