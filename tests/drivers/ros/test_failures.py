"""Nodes of ours that are killed or frozen, emergency stops, and what the devices then say."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from beltsort.cell import CommandError, EmergencyStopError, Outcome
from beltsort.drivers.ros.arm import RosArm
from beltsort.drivers.ros.belt import RosBelt
from beltsort.drivers.ros.camera import RosCamera
from tests.drivers.ros.fixtures import an_id
from tests.drivers.ros.rig import PeerRig, await_ready
from tests.waiting import alive, wait_until

pytestmark = pytest.mark.process


def own_nodes(rig: PeerRig) -> list[int]:
    """Return the processes in which our nodes run."""
    children = Path(f"/proc/{os.getpid()}/task/{os.getpid()}/children").read_text().split()
    return [pid for pid in map(int, children) if rig.node_program in Path(f"/proc/{pid}/cmdline").read_text()]


def frame_unless_ended(camera: RosCamera) -> str:
    """Scan; a node whose end is only noticed by asking it is to be asked again."""
    try:
        return camera.scan(not_before=time.monotonic(), timeout=30.0).frame
    except CommandError as reason:
        if "ended" not in str(reason):
            raise
        return ""


def test_our_own_node_frozen_or_killed(rig: PeerRig) -> None:
    before = own_nodes(rig)
    with rig.camera() as camera:
        await_ready(camera)
        (node,) = set(own_nodes(rig)) - set(before)
        assert os.getpgid(node) != os.getpgid(0)  # Control-C passes it by
        os.kill(node, signal.SIGSTOP)
        with pytest.raises(CommandError, match=r"node\b.*\(newest\).*\d s\b"):
            camera.scan(not_before=0.0, timeout=0.5)
        os.kill(node, signal.SIGCONT)
        assert camera.scan(not_before=time.monotonic(), timeout=10.0).frame == "optical"
        os.kill(node, signal.SIGKILL)
        wait_until(lambda: not alive(node), "our node ends")
        assert wait_until(lambda: frame_unless_ended(camera), "a new node") == "optical"
    assert own_nodes(rig) == before


def test_our_node_ends_with_us(rig: PeerRig) -> None:
    script = f"""
import os
{rig.connecting}
children = open(f"/proc/{{os.getpid()}}/task/{{os.getpid()}}/children").read()
print(children, flush=True)
os._exit(1)
"""
    ended = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    (node,) = map(int, ended.stdout.split())
    wait_until(lambda: not alive(node), "the node ends with the process that started it")


def test_a_start_that_hangs(rig: PeerRig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    belt = rig.hanging_belt(tmp_path, monkeypatch)
    before = own_nodes(rig)
    with pytest.raises(CommandError, match=r"node\b.*\(starting\).*\d s\b.*connect\(\)") as error:
        belt.advance_to(1, an_id(), timeout=0.5)
    assert error.value.outcome is Outcome.NOT_DONE
    assert own_nodes(rig) == before


def test_the_emergency_stop(rig: PeerRig, arm: RosArm, belt: RosBelt) -> None:
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
    for device in (arm, belt):
        health = device.health()
        assert (health.ready, health.emergency_stop) == (False, True)
    with pytest.raises(EmergencyStopError) as error:
        belt.advance_to(10**7, an_id())
    assert error.value.outcome is Outcome.NOT_DONE
    rig.mend()
    wait_until(lambda: arm.health().ready, "the arm hears that the stop is released")
    assert arm.move_to(0, an_id(), timeout=10.0) > 0.0


def test_an_emergency_stop_that_nothing_tells(rig: PeerRig) -> None:
    with rig.arm(emergency_stop_topic="/silent") as arm:
        arm.connect()
        with pytest.raises(CommandError, match=r"/silent\b.*\bemergency stop\b") as error:
            arm.move_to(0, an_id(), timeout=5.0)
        assert error.value.outcome is Outcome.NOT_DONE
