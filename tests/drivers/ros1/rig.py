"""A master and a peer in processes of their own, on the loopback, stopped by their process ids."""

import os
import subprocess
import sys
from dataclasses import asdict, replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

from beltsort.cell import CommandError
from beltsort.drivers.ros1 import Ros1Arm, Ros1Belt, Ros1Camera, Ros1Sorter
from beltsort.drivers.ros1.master import Master
from tests.drivers.ros.machine import Settings
from tests.drivers.ros.rig import PeerRig
from tests.drivers.ros1 import scene
from tests.ports import HeldPort
from tests.waiting import wait_until

MASTER = "import rosmaster, sys; rosmaster.rosmaster_main(['rosmaster', '--core', '-p', sys.argv[1]])"


class Rig(PeerRig):
    """Starts, freezes and kills a master and a peer."""

    node_program = "ros1.node"

    def __init__(self, directory: Path) -> None:
        self._port = HeldPort()
        self.uri = f"http://127.0.0.1:{self._port.number}"
        address = {"ROS_MASTER_URI": self.uri, "ROS_IP": "127.0.0.1", "ROS_HOSTNAME": "127.0.0.1"}
        path = {"PYTHONPATH": os.pathsep.join(entry or os.curdir for entry in sys.path)}
        self.connecting = (
            "from beltsort.drivers.ros1 import Ros1Belt, Ros1BeltOptions\n"
            f"Ros1Belt(Ros1BeltOptions(master={self.uri!r})).connect()\n"
        )
        super().__init__({**os.environ, **address, **path, "ROS_LOG_DIR": str(directory)})
        self.master = self.start_master()
        self.peer = self.start_peer()

    def start_master(self) -> subprocess.Popen[str]:
        self.master = self._start(sys.executable, "-c", MASTER, str(self._port.number))
        wait_until(self.master_answers, "the master starts")
        return self.master

    def master_answers(self) -> bool:
        try:
            Master(self.uri).identity(1.0)
        except CommandError:
            return False
        return True

    def start_peer(self) -> subprocess.Popen[str]:
        return self._started(sys.executable, "-m", "tests.drivers.ros1.peer")

    def arm(self, *, action: bool = False, **changes: Any) -> Ros1Arm:
        return Ros1Arm(replace(scene.arm(self.uri, action=action), **changes))

    def camera(self, *, by_joints: bool = False, **changes: Any) -> Ros1Camera:
        options = scene.camera_by_joints if by_joints else scene.camera_by_tf
        return Ros1Camera(replace(options(self.uri), **changes))

    def belt(self) -> Ros1Belt:
        return Ros1Belt(scene.belt(self.uri))

    def sorter(self) -> Ros1Sorter:
        return Ros1Sorter(scene.sorter(self.uri))

    def hanging_belt(self, folder: Path, patch: pytest.MonkeyPatch) -> Ros1Belt:
        (folder / "rospy.py").write_text("import time\ntime.sleep(60)\n")
        patch.syspath_prepend(str(folder))
        return self.belt()

    def mend(self) -> None:
        """See to it that master and peer run and do what they do at first."""
        for process, start in ((self.master, self.start_master), (self.peer, self.start_peer)):
            if process.poll() is not None:
                start()
        self.thaw()
        self.tell(**asdict(Settings()))

    def close(self) -> None:
        for process in (self.peer, self.master):
            self.kill(process)
        self._port.close()


def require_ros() -> None:
    """End the test where ROS is missing."""
    if find_spec("rospy") is None or find_spec("rosmaster") is None:
        lacking = "rospy or rosmaster is missing; scripts/bootstrap installs them where apt has them"
        (pytest.fail if os.environ.get("CI") else pytest.skip)(lacking)
