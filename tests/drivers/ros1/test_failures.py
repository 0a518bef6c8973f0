"""A master that is killed, frozen or missing, and what the devices then say."""

import os
import signal
from pathlib import Path

import pytest

from beltsort.cell import CommandError, Outcome
from beltsort.drivers.ros1 import Ros1Arm, Ros1Camera
from tests.drivers.ros.fixtures import an_id
from tests.drivers.ros1 import scene
from tests.drivers.ros1.rig import Rig
from tests.ports import HeldPort

pytestmark = pytest.mark.process


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
        rig.belt().connect()
