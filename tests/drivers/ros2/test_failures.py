"""A peer that is killed, and what is missing; what the devices then say."""

import dataclasses
import sys
from pathlib import Path
from typing import Any

import pytest

from beltsort.cell import CommandError, Outcome
from beltsort.drivers.ros2 import Ros2Belt
from tests.drivers.ros2 import scene
from tests.drivers.ros2.rig import Rig
from tests.waiting import wait_until

pytestmark = pytest.mark.process


def test_a_node_that_was_killed_is_named_and_another_one_is_told_apart(rig: Rig, belt: Ros2Belt) -> None:
    boot = belt.health().boot_id
    rig.kill(rig.peer)
    health = belt.health()
    assert (health.ready, health.boot_id) == (False, boot)
    assert "/peer" in health.fault
    assert "/belt/object" in health.fault
    rig.start_peer()
    wait_until(lambda: belt.health().ready, "the belt is ready")
    restarted = belt.health().boot_id
    assert restarted != boot
    assert belt.health().boot_id == restarted


def test_a_sourced_file_provides_ros(rig: Rig, tmp_path: Path) -> None:
    """The interpreter is then the first python3 of the sourced environment."""
    setup = tmp_path / "it's a setup.bash"
    setup.write_text(f'export PATH="{Path(scene.PYTHON).parent}:$PATH"\n')
    with Ros2Belt(dataclasses.replace(scene.belt(rig.domain), python="", setup=str(setup))) as belt:
        assert belt.position() >= 0


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"python": sys.executable}, r"\brclpy\b.*/opt/ros/\w+/setup\.bash.*pip install 'ros-rclpy"),
        ({"python": "/no/python"}, r"\bpython is '/no/python'.*/opt/ros/\w+/setup\.bash"),
        ({"setup": "/no/setup.bash"}, r"\bsetup is '/no/setup\.bash'.*/opt/ros/\w+/setup\.bash"),
    ],
    ids=["no rclpy", "no interpreter", "no file"],
)
def test_an_installation_that_has_no_ros(rig: Rig, changes: dict[str, Any], said: str) -> None:
    with pytest.raises(CommandError, match=said) as error:
        Ros2Belt(dataclasses.replace(scene.belt(rig.domain), **changes)).connect()
    assert error.value.outcome is Outcome.NOT_DONE


def test_an_emergency_stop_that_was_published_once_is_heard_later(rig: Rig) -> None:
    """Its publisher keeps the last message for those that come later, as a latched topic of ROS 1 does."""
    options = dataclasses.replace(scene.belt(rig.domain), emergency_stop_topic="/latched_stop")
    with Ros2Belt(options) as belt:
        assert wait_until(lambda: belt.health().emergency_stop, "the latched state arrives")
