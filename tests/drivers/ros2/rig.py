"""A peer on ROS 2 in a process of its own, with an interpreter and a domain of its own."""

import os
import socket
import subprocess
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any
from uuid import uuid4

import pytest

from beltsort.drivers.ros2 import Ros2Arm, Ros2Belt, Ros2Camera, Ros2Sorter
from tests.drivers.ros.machine import Settings
from tests.drivers.ros.rig import PeerRig
from tests.drivers.ros2 import scene
from tests.drivers.ros2.scene import PYTHON

ROOT = Path(__file__).parents[3]
PEER = Path(__file__).with_name("peer.py")

LOCKS = 17400
"""Port that is bound, but not listened at, by who uses domain 0; those of the other domains follow."""


class HeldDomain:
    """A ROS_DOMAIN_ID that no other test uses while it is held, here or by a peer that inherits `lock`."""

    def __init__(self) -> None:
        for number in range(1, 100):
            lock = socket.socket()
            try:
                lock.bind(("127.0.0.1", LOCKS + number))
            except OSError:
                lock.close()
                continue
            self._lock, self.number = lock, number
            return
        raise AssertionError("no domain is free")

    @property
    def lock(self) -> int:
        """File descriptor that holds the domain."""
        return self._lock.fileno()

    def close(self) -> None:
        self._lock.close()


class Rig(PeerRig):
    """Starts, freezes and kills a peer: that of this folder, or another program that does what it does."""

    node_program = "ros2/start.py"

    def __init__(self, directory: Path, *peer: str) -> None:
        self._command = peer or (PYTHON, str(PEER))
        self._held = HeldDomain()
        self.domain = self._held.number
        self.connecting = (
            "from beltsort.drivers.ros2 import Ros2Belt, Ros2BeltOptions\n"
            f"Ros2Belt(Ros2BeltOptions(python={PYTHON!r}, domain_id={self.domain})).connect()\n"
        )
        ros = {
            "ROS_DOMAIN_ID": str(self.domain),
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
            "ROS_LOG_DIR": str(directory),
        }
        super().__init__({**os.environ, **ros, "PYTHONPATH": str(ROOT)}, self._held.lock)
        self.start_peer()

    def start_peer(self) -> subprocess.Popen[str]:
        return self._started(*self._command)

    def arm(self, *, action: bool = False, **changes: Any) -> Ros2Arm:
        return Ros2Arm(replace(scene.arm(self.domain, action=action), **changes))

    def camera(self, *, by_joints: bool = False, **changes: Any) -> Ros2Camera:
        options = scene.camera_by_joints if by_joints else scene.camera_by_tf
        return Ros2Camera(replace(options(self.domain), **changes))

    def belt(self) -> Ros2Belt:
        return Ros2Belt(scene.belt(self.domain))

    def sorter(self) -> Ros2Sorter:
        return Ros2Sorter(scene.sorter(self.domain))

    def hanging_belt(self, folder: Path, patch: pytest.MonkeyPatch) -> Ros2Belt:
        setup = folder / "setup.bash"
        setup.write_text("sleep 60\n")
        return Ros2Belt(replace(scene.belt(self.domain), setup=str(setup)))

    def mend(self) -> None:
        """See to it that the peer runs and does what it does at first."""
        if self.peer.poll() is not None:
            self.start_peer()
        self.thaw()
        self.tell(**asdict(Settings()))

    def close(self) -> None:
        self.kill(self.peer)
        self._held.close()


def set_going(rig: Rig, belt: Ros2Belt) -> None:
    """Bring a belt that was stopped on its way to an object, from which it can be advanced by steps."""
    world = rig.tell()
    if world["halted"]:
        belt.advance_to(world["object"] + 1, uuid4().hex, timeout=60.0)


FULL = ("rclpy", "tf2_msgs", "control_msgs", "visualization_msgs", "std_srvs", "moveit_msgs")
"""Packages that the peers of a whole cell need."""


def require_ros2(*needed: str) -> None:
    """End the test where ROS 2 is missing, or one of its packages: those of `FULL`, or others."""
    packages = {path.name for path in Path(PYTHON).parents[1].glob("lib/python*/site-packages/*")}
    lacking = set(needed or FULL) - packages
    if lacking:
        reason = f"{', '.join(sorted(lacking))} missing in {PYTHON}; see scripts/bootstrap"
        (pytest.fail if os.environ.get("CI") else pytest.skip)(reason)
