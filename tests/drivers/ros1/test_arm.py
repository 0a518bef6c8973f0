"""An arm on ROS 1, by joint commands and by an action."""

import dataclasses
import time
from collections.abc import Iterator
from uuid import uuid4

import pytest

from beltsort.cell import CommandError, Outcome
from beltsort.drivers.ros1 import Ros1Arm
from tests.drivers.ros1 import scene
from tests.drivers.ros1.rig import Rig
from tests.waiting import wait_until

pytestmark = pytest.mark.process


@pytest.fixture(scope="package")
def shared_acting_arm(shared: Rig) -> Iterator[Ros1Arm]:
    with Ros1Arm(scene.arm(shared.uri, action=True)) as arm:
        yield arm


@pytest.fixture(params=["joint commands", "action"])
def either(
    rig: Rig, shared_arm: Ros1Arm, shared_acting_arm: Ros1Arm, request: pytest.FixtureRequest
) -> Ros1Arm:
    return shared_acting_arm if request.param == "action" else shared_arm


def an_id() -> str:
    return uuid4().hex


def test_it_moves_and_tells_when_it_stopped(either: Ros1Arm) -> None:
    for viewpoint in (0, 1):
        began, one = time.monotonic(), an_id()
        stop = either.move_to(viewpoint, one, timeout=10.0)
        assert began < stop <= time.monotonic()
        assert either.outcome_of(one) is Outcome.DONE


def test_the_flange_is_where_tf_says(rig: Rig, arm: Ros1Arm) -> None:
    assert arm.flange_pose() is None, "no frame is named"
    options = dataclasses.replace(scene.arm(rig.uri), world_frame="world", flange_frame="optical")
    with Ros1Arm(options) as telling:
        telling.move_to(1, an_id(), timeout=10.0)
        pose = telling.flange_pose(timeout=10.0)
        assert pose is not None
        assert pose[2, 3] == pytest.approx(scene.TAUGHT["p2"]["elbow"], abs=options.tolerance)
    said = r"pose of 'hand'.*\b1 s\b.*\btransforms\b.*'hand'.*'world'"
    with Ros1Arm(dataclasses.replace(options, flange_frame="hand")) as lost:
        lost.connect()
        with pytest.raises(CommandError, match=said):
            lost.flange_pose(timeout=1.0)


def test_a_refused_goal_says_what_the_action_says(rig: Rig, shared_acting_arm: Ros1Arm) -> None:
    shared_acting_arm.move_to(1, an_id(), timeout=10.0)
    rig.tell(verdict=5)
    with pytest.raises(CommandError, match=r"\(5\).*says the peer") as error:
        shared_acting_arm.move_to(0, an_id(), timeout=10.0)
    assert error.value.outcome is Outcome.NOT_DONE


def test_a_stop_from_another_thread_ends_the_motion(rig: Rig, either: Ros1Arm) -> None:
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
