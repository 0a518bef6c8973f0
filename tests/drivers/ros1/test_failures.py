"""What is killed, frozen or restarted in the middle, and what the devices then say."""

import dataclasses
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from uuid import uuid4

import pytest

from beltsort.cell import CommandError, EmergencyStopError, Outcome
from beltsort.drivers.ros1 import Ros1Arm, Ros1Belt, Ros1Camera
from tests.drivers.ros1 import scene
from tests.drivers.ros1.rig import Rig
from tests.ports import HeldPort
from tests.waiting import alive, wait_until

pytestmark = pytest.mark.process


def an_id() -> str:
    return uuid4().hex


def own_nodes() -> list[int]:
    """Return the processes in which our nodes run."""
    children = Path(f"/proc/{os.getpid()}/task/{os.getpid()}/children").read_text().split()
    return [pid for pid in map(int, children) if "ros1.node" in Path(f"/proc/{pid}/cmdline").read_text()]


def test_the_master_killed_mid_command_and_restarted(rig: Rig, arm: Ros1Arm) -> None:
    arm.move_to(0, an_id(), timeout=10.0)
    boot = arm.health().boot_id
    rig.tell(speed=0.2)
    killing = rig.when_busy("arm", lambda: rig.kill(rig.master))
    assert arm.move_to(1, an_id(), timeout=30.0) > 0.0  # arm and driver talk to each other
    killing.join()
    with pytest.raises(CommandError, match=r"\bmaster\b.*http://127\.0\.0\.1:\d+") as error:
        arm.move_to(0, an_id(), timeout=5.0)
    assert error.value.outcome is Outcome.NOT_DONE
    with pytest.raises(CommandError, match=r"\bmaster\b.*http://127\.0\.0\.1:\d+"):
        arm.health()
    rig.kill(rig.peer)
    rig.start_master()
    rig.start_peer()
    assert arm.move_to(0, an_id(), timeout=20.0) > 0.0
    assert arm.health().boot_id != boot


def test_a_frozen_master_is_not_waited_for(rig: Rig, camera: Ros1Camera) -> None:
    camera.connect()
    os.kill(rig.master.pid, signal.SIGSTOP)
    try:
        with pytest.raises(CommandError, match=r"\bmaster\b.*http://127\.0\.0\.1:\d+"):
            camera.scan(not_before=0.0, timeout=0.5)
    finally:
        os.kill(rig.master.pid, signal.SIGCONT)
    assert camera.scan(not_before=0.0, timeout=10.0).frame == "optical"


def frame_unless_ended(camera: Ros1Camera) -> str:
    """Scan; a node whose end is only noticed by asking it is to be asked again."""
    try:
        return camera.scan(not_before=time.monotonic(), timeout=30.0).frame
    except CommandError as reason:
        if "ended" not in str(reason):
            raise
        return ""


def test_our_own_node_frozen_or_killed(rig: Rig) -> None:
    before = own_nodes()
    with Ros1Camera(scene.camera_by_tf(rig.uri)) as camera:
        camera.connect()
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
import dataclasses
import os
from beltsort.drivers.ros1 import Ros1Belt, Ros1BeltOptions
Ros1Belt(Ros1BeltOptions(master={rig.uri!r})).connect()
children = open(f"/proc/{{os.getpid()}}/task/{{os.getpid()}}/children").read()
print(children, flush=True)
os._exit(1)
"""
    ended = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    (node,) = map(int, ended.stdout.split())
    wait_until(lambda: not alive(node), "the node ends with the process that started it")


def test_without_a_master() -> None:
    with (
        HeldPort() as port,
        Ros1Camera(scene.camera_by_tf(f"http://127.0.0.1:{port.number}")) as camera,
        pytest.raises(CommandError, match=r"http://127\.0\.0\.1:\d+.*ConnectionRefusedError") as error,
    ):
        camera.connect()
    assert error.value.outcome is Outcome.NOT_DONE


def test_without_rospy(rig: Rig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "rospy.py").write_text("raise ImportError('no rospy here')\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    with pytest.raises(CommandError, match=r"\(no rospy here\).*apt-get install .*python3-rospy"):
        Ros1Belt(scene.belt(rig.uri)).connect()


def test_a_start_that_hangs(rig: Rig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "rospy.py").write_text("import time\ntime.sleep(60)\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    before = own_nodes()
    with pytest.raises(CommandError, match=r"node\b.*\(starting\).*\d s\b.*connect\(\)") as error:
        Ros1Belt(scene.belt(rig.uri)).advance_to(1, "one", timeout=0.5)
    assert error.value.outcome is Outcome.NOT_DONE
    assert own_nodes() == before


def test_the_emergency_stop(rig: Rig, arm: Ros1Arm, belt: Ros1Belt) -> None:
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
    with pytest.raises(EmergencyStopError) as error:
        belt.advance_to(10**7, an_id())
    assert error.value.outcome is Outcome.NOT_DONE
    for device in (arm, belt):
        health = device.health()
        assert (health.ready, health.emergency_stop) == (False, True)
    rig.mend()
    wait_until(lambda: arm.health().ready, "the arm hears that the stop is released")
    assert arm.move_to(0, an_id(), timeout=10.0) > 0.0


def test_an_emergency_stop_that_nothing_tells(rig: Rig) -> None:
    options = dataclasses.replace(scene.arm(rig.uri), emergency_stop_topic="/silent")
    with Ros1Arm(options) as arm:
        arm.connect()
        with pytest.raises(CommandError, match=r"/silent\b.*\bemergency stop\b") as error:
            arm.move_to(0, an_id(), timeout=2.0)
        assert error.value.outcome is Outcome.NOT_DONE
