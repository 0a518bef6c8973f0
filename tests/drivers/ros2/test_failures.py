"""What is killed, frozen or missing, and what the devices then say."""

import dataclasses
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any
from uuid import uuid4

import pytest

from beltsort.cell import CommandError, EmergencyStopError, Outcome
from beltsort.drivers.ros2 import Ros2Arm, Ros2Belt, Ros2Camera
from tests.drivers.ros2 import scene
from tests.drivers.ros2.rig import Rig
from tests.waiting import alive, wait_until

pytestmark = pytest.mark.process


def an_id() -> str:
    return uuid4().hex


def own_nodes() -> list[int]:
    """Return the processes in which our nodes run."""
    children = Path(f"/proc/{os.getpid()}/task/{os.getpid()}/children").read_text().split()
    return [pid for pid in map(int, children) if "ros2/start.py" in Path(f"/proc/{pid}/cmdline").read_text()]


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


def frame_unless_ended(camera: Ros2Camera) -> str:
    """Scan; a node whose end is only noticed by asking it is to be asked again."""
    try:
        return camera.scan(not_before=time.monotonic(), timeout=30.0).frame
    except CommandError as reason:
        if "ended" not in str(reason):
            raise
        return ""


def test_our_own_node_frozen_or_killed(rig: Rig) -> None:
    before = own_nodes()
    with Ros2Camera(scene.camera_by_tf(rig.domain)) as camera:
        camera.scan(not_before=0.0, timeout=30.0)
        (node,) = set(own_nodes()) - set(before)
        assert os.getpgid(node) != os.getpgid(0)  # Control-C passes it by
        os.kill(node, signal.SIGSTOP)
        with pytest.raises(CommandError, match=r"node\b.*\(newest\).*\d s\b"):
            camera.scan(not_before=0.0, timeout=0.5)
        os.kill(node, signal.SIGCONT)
        assert camera.scan(not_before=time.monotonic(), timeout=10.0).frame == "optical"
        os.kill(node, signal.SIGKILL)
        wait_until(lambda: not alive(node), "our node ends")
        assert wait_until(lambda: frame_unless_ended(camera), "a new node") == "optical"
    assert own_nodes() == before


def test_our_node_ends_with_us(rig: Rig) -> None:
    script = f"""
import os
from beltsort.drivers.ros2 import Ros2Belt, Ros2BeltOptions
Ros2Belt(Ros2BeltOptions(python={scene.PYTHON!r}, domain_id={rig.domain})).connect()
children = open(f"/proc/{{os.getpid()}}/task/{{os.getpid()}}/children").read()
print(children, flush=True)
os._exit(1)
"""
    ended = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    (node,) = map(int, ended.stdout.split())
    wait_until(lambda: not alive(node), "the node ends with the process that started it")


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


def test_a_start_that_hangs(rig: Rig, tmp_path: Path) -> None:
    setup = tmp_path / "setup.bash"
    setup.write_text("sleep 60\n")
    before = own_nodes()
    with pytest.raises(CommandError, match=r"node\b.*\(starting\).*\d s\b.*connect\(\)") as error:
        Ros2Belt(dataclasses.replace(scene.belt(rig.domain), setup=str(setup))).advance_to(
            1, "one", timeout=0.5
        )
    assert error.value.outcome is Outcome.NOT_DONE
    assert own_nodes() == before


def test_the_emergency_stop(rig: Rig, arm: Ros2Arm, belt: Ros2Belt) -> None:
    arm.move_to(0, an_id(), timeout=10.0)
    rig.tell(speed=0.1)
    pressing = rig.when_busy("arm", lambda: rig.tell(emergency=True))
    with pytest.raises(EmergencyStopError) as error:
        arm.move_to(1, an_id(), timeout=10.0)
    pressing.join()
    assert error.value.outcome is Outcome.UNKNOWN
    with pytest.raises(EmergencyStopError, match=r"\bemergency stop\b") as error:
        arm.move_to(0, an_id())
    assert error.value.outcome is Outcome.NOT_DONE
    wait_until(lambda: belt.health().emergency_stop, "the belt hears of it, too")
    assert not arm.health().ready
    assert not belt.health().ready
    with pytest.raises(EmergencyStopError) as error:
        belt.advance_to(10**7, an_id())
    assert error.value.outcome is Outcome.NOT_DONE
    rig.mend()
    wait_until(lambda: arm.health().ready, "the arm hears that the stop is released")
    assert arm.move_to(0, an_id(), timeout=10.0) > 0.0


def test_an_emergency_stop_that_was_published_once_is_heard_later(rig: Rig) -> None:
    """Its publisher keeps the last message for those that come later, as a latched topic of ROS 1 does."""
    options = dataclasses.replace(scene.belt(rig.domain), emergency_stop_topic="/latched_stop")
    with Ros2Belt(options) as belt:
        assert wait_until(lambda: belt.health().emergency_stop, "the latched state arrives")


def test_an_emergency_stop_that_nothing_tells(rig: Rig) -> None:
    options = dataclasses.replace(scene.arm(rig.domain), emergency_stop_topic="/silent")
    with Ros2Arm(options) as arm:
        arm.connect()
        with pytest.raises(CommandError, match=r"/silent\b.*\bemergency stop\b") as error:
            arm.move_to(0, an_id(), timeout=5.0)
        assert error.value.outcome is Outcome.NOT_DONE
