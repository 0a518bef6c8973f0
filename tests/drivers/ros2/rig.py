"""A peer on ROS 2 in a process of its own, with an interpreter and a domain of its own."""

import os
import socket
import subprocess
from dataclasses import asdict
from pathlib import Path
from uuid import uuid4

import pytest

from beltsort.drivers.ros2 import Ros2Belt
from tests.drivers.ros.machine import Settings
from tests.drivers.ros.rig import PeerRig
from tests.drivers.ros2.scene import PYTHON

ROOT = Path(__file__).parents[3]
PEER = Path(__file__).with_name("peer.py")

LOCKS = 17400
"""Port that is bound, but not listened at, by who uses domain 0; those of the other domains follow."""


class HeldDomain:
    """A ROS_DOMAIN_ID that no other test uses while it is held."""

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

    def close(self) -> None:
        self._lock.close()


class Rig(PeerRig):
    """Starts, freezes and kills a peer: that of this folder, or another program that does what it does."""

    def __init__(self, directory: Path, *peer: str) -> None:
        self._command = peer or (PYTHON, str(PEER))
        self._held = HeldDomain()
        self.domain = self._held.number
        ros = {
            "ROS_DOMAIN_ID": str(self.domain),
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
            "ROS_LOG_DIR": str(directory),
        }
        super().__init__({**os.environ, **ros, "PYTHONPATH": str(ROOT)})
        self.start_peer()

    def start_peer(self) -> subprocess.Popen[str]:
        return self._started(*self._command)

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


def require_ros2() -> None:
    """End the test where ROS 2 is missing."""
    packages = {path.name for path in Path(PYTHON).parents[1].glob("lib/python*/site-packages/*")}
    needed = {"rclpy", "tf2_msgs", "control_msgs", "visualization_msgs", "std_srvs", "moveit_msgs"}
    lacking = needed - packages
    if lacking:
        reason = f"{', '.join(sorted(lacking))} missing in {PYTHON}; see scripts/bootstrap"
        (pytest.fail if os.environ.get("CI") else pytest.skip)(reason)
