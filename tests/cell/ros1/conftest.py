"""A master and a peer in processes of their own, on the loopback, stopped by their process ids."""

import json
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import asdict
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

from beltsort.cell import CommandError, within
from beltsort.cell.ros1 import Ros1Arm, Ros1Belt, Ros1Camera
from beltsort.cell.ros1.master import Master
from tests.cell.ros1 import scene

MASTER = "import rosmaster, sys; rosmaster.rosmaster_main(['rosmaster', '--core', '-p', sys.argv[1]])"
START_TIMEOUT = 30.0


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port: int = server.getsockname()[1]
        return port


class Rig:
    """Starts, freezes and kills a master and a peer."""

    def __init__(self, directory: Path) -> None:
        self._port = free_port()
        self.uri = f"http://127.0.0.1:{self._port}"
        address = {"ROS_MASTER_URI": self.uri, "ROS_IP": "127.0.0.1", "ROS_HOSTNAME": "127.0.0.1"}
        path = {"PYTHONPATH": os.pathsep.join(entry or os.curdir for entry in sys.path)}
        self._environment = {**os.environ, **address, **path, "ROS_LOG_DIR": str(directory)}
        self.master = self.start_master()
        self.peer = self.start_peer()

    def start_master(self) -> subprocess.Popen[str]:
        self.master = self._start("-c", MASTER, str(self._port))
        end = time.monotonic() + START_TIMEOUT
        while True:
            try:
                Master(self.uri).identity(1.0)
            except CommandError:
                assert time.monotonic() < end, "the master did not start"
                time.sleep(0.02)
            else:
                return self.master

    def start_peer(self) -> subprocess.Popen[str]:
        self.peer = self._start("-m", "tests.cell.ros1.peer")
        assert self.peer.stdout is not None
        assert within(START_TIMEOUT, "the peer's start", self.peer.stdout.readline) == "ready\n"
        return self.peer

    def tell(self, **settings: Any) -> None:
        """Change what the peer does; without settings: back to what it does at first."""
        assert self.peer.stdin is not None
        self.peer.stdin.write(json.dumps(settings or asdict(scene.Settings())) + "\n")
        self.peer.stdin.flush()

    def kill(self, process: subprocess.Popen[str]) -> None:
        process.kill()
        process.wait(10.0)

    def freeze(self) -> None:
        os.kill(self.peer.pid, signal.SIGSTOP)

    def thaw(self) -> None:
        os.kill(self.peer.pid, signal.SIGCONT)

    def close(self) -> None:
        for process in (self.peer, self.master):
            self.kill(process)

    def _start(self, *arguments: str) -> subprocess.Popen[str]:
        return subprocess.Popen(
            [sys.executable, *arguments],
            env=self._environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )


@pytest.fixture(scope="session")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Rig]:
    if find_spec("rospy") is None or find_spec("rosmaster") is None:
        lacking = "rospy or rosmaster is missing; scripts/bootstrap installs them where apt has them"
        (pytest.fail if os.environ.get("CI") else pytest.skip)(lacking)
    directory = tmp_path_factory.mktemp("ros")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ROS_LOG_DIR", str(directory))
        rig = Rig(directory)
        yield rig
        rig.close()


@pytest.fixture
def rig(shared: Rig) -> Iterator[Rig]:
    """Return the rig of all tests, its peer running and well-behaved."""
    for process, start in ((shared.master, shared.start_master), (shared.peer, shared.start_peer)):
        if process.poll() is not None:
            start()
    yield shared
    if shared.peer.poll() is None:
        shared.thaw()
        shared.tell()


@pytest.fixture(scope="session")
def shared_camera(shared: Rig) -> Iterator[Ros1Camera]:
    with Ros1Camera(scene.camera_by_tf(shared.uri)) as camera:
        yield camera


@pytest.fixture(scope="session")
def shared_arm(shared: Rig) -> Iterator[Ros1Arm]:
    with Ros1Arm(scene.arm(shared.uri)) as arm:
        yield arm


@pytest.fixture(scope="session")
def shared_belt(shared: Rig) -> Iterator[Ros1Belt]:
    with Ros1Belt(scene.belt(shared.uri)) as belt:
        yield belt


@pytest.fixture
def camera(rig: Rig, shared_camera: Ros1Camera) -> Ros1Camera:
    return shared_camera


@pytest.fixture
def arm(rig: Rig, shared_arm: Ros1Arm) -> Ros1Arm:
    return shared_arm


@pytest.fixture
def belt(rig: Rig, shared_belt: Ros1Belt) -> Ros1Belt:
    return shared_belt
