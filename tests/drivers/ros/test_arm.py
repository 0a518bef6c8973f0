"""An arm on ROS, by a topic and by an action."""

import time

import pytest

from beltsort.cell import CommandError, Outcome
from beltsort.drivers.ros.arm import RosArm
from tests.drivers.ros.fixtures import an_id
from tests.drivers.ros.rig import PeerRig, await_ready
from tests.drivers.ros.scenery import TAUGHT
from tests.waiting import wait_until

pytestmark = pytest.mark.process


@pytest.fixture(params=["arm", "acting_arm"], ids=["topic", "action"])
def either(rig: PeerRig, request: pytest.FixtureRequest) -> RosArm:
    arm: RosArm = request.getfixturevalue(request.param)
    return arm


def test_it_moves_and_tells_when_it_stopped(either: RosArm) -> None:
    for viewpoint in (0, 1):
        began, one = time.monotonic(), an_id()
        stop = either.move_to(viewpoint, one, timeout=10.0)
        assert began < stop <= time.monotonic()
        assert either.outcome_of(one) is Outcome.DONE


def test_the_flange_is_where_tf_says(rig: PeerRig, arm: RosArm) -> None:
    assert arm.flange_pose() is None, "no frame is named"
    with rig.arm(world_frame="world", flange_frame="optical") as telling:
        await_ready(telling)
        telling.move_to(1, an_id(), timeout=10.0)
        pose = telling.flange_pose(timeout=10.0)
        assert pose is not None
        assert pose[2, 3] == pytest.approx(TAUGHT["p2"]["elbow"], abs=0.02)
    said = r"pose of 'hand'.*\b1 s\b.*\btransforms\b.*'hand'.*'world'"
    with rig.arm(world_frame="world", flange_frame="hand") as lost:
        await_ready(lost)
        with pytest.raises(CommandError, match=said):
            lost.flange_pose(timeout=1.0)


def test_a_stop_from_another_thread_ends_the_motion(rig: PeerRig, either: RosArm) -> None:
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
