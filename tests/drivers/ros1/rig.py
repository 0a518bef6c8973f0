"""A master and a peer in processes of their own, on the loopback, stopped by their process ids."""

import json
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from dataclasses import asdict
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

from beltsort.cell import CommandError, within
from beltsort.drivers.ros1.master import Master
from tests.drivers.ros.machine import Settings
from tests.ports import HeldPort
from tests.waiting import PATIENCE, wait_until

MASTER = "import rosmaster, sys; rosmaster.rosmaster_main(['rosmaster', '--core', '-p', sys.argv[1]])"


class Rig:
    """Starts, freezes and kills a master and a peer."""

    def __init__(self, directory: Path) -> None:
        self._port = HeldPort()
        self.uri = f"http://127.0.0.1:{self._port.number}"
        address = {"ROS_MASTER_URI": self.uri, "ROS_IP": "127.0.0.1", "ROS_HOSTNAME": "127.0.0.1"}
        path = {"PYTHONPATH": os.pathsep.join(entry or os.curdir for entry in sys.path)}
        self._environment = {**os.environ, **address, **path, "ROS_LOG_DIR": str(directory)}
        self.master = self.start_master()
        self.peer = self.start_peer()

    def start_master(self) -> subprocess.Popen[str]:
        self.master = self._start("-c", MASTER, str(self._port.number))
        wait_until(self.master_answers, "the master starts")
        return self.master

    def master_answers(self) -> bool:
        try:
            Master(self.uri).identity(1.0)
        except CommandError:
            return False
        return True

    def start_peer(self) -> subprocess.Popen[str]:
        self.peer = self._start("-m", "tests.drivers.ros1.peer")
        assert self.peer.stdout is not None
        assert within(PATIENCE, "the peer's start", self.peer.stdout.readline) == "ready\n"
        return self.peer

    def tell(self, **settings: Any) -> dict[str, Any]:
        """Change what the peer does; return what the world is like once all that it publishes is as told."""
        world = self._say(settings)
        if not settings:
            return world
        # The beat under way may still be as before; the next one is over when another one begins.
        return wait_until(
            lambda: (later := self._say({}))["beats"] >= world["beats"] + 2 and later, "the peer goes on"
        )

    def when_busy(self, role: str, act: Callable[[], object]) -> threading.Thread:
        """Let another thread act as soon as arm, belt or sorter does."""

        def wait_and_act() -> None:
            wait_until(lambda: self.tell()["busy"][role], f"the {role} acts")
            act()

        thread = threading.Thread(target=wait_and_act, daemon=True)
        thread.start()
        return thread

    def _say(self, settings: dict[str, Any]) -> dict[str, Any]:
        """Send a line to the peer, and return its answer."""
        assert self.peer.stdin is not None
        assert self.peer.stdout is not None
        self.peer.stdin.write(json.dumps(settings) + "\n")
        self.peer.stdin.flush()
        world: dict[str, Any] = json.loads(within(PATIENCE, "the peer's answer", self.peer.stdout.readline))
        return world

    def mend(self) -> None:
        """See to it that master and peer run and do what they do at first."""
        for process, start in ((self.master, self.start_master), (self.peer, self.start_peer)):
            if process.poll() is not None:
                start()
        self.thaw()
        self.tell(**asdict(Settings()))

    def kill(self, process: subprocess.Popen[str]) -> None:
        process.kill()
        process.wait()

    def freeze(self) -> None:
        os.kill(self.peer.pid, signal.SIGSTOP)

    def thaw(self) -> None:
        os.kill(self.peer.pid, signal.SIGCONT)

    def close(self) -> None:
        for process in (self.peer, self.master):
            self.kill(process)
        self._port.close()

    def _start(self, *arguments: str) -> subprocess.Popen[str]:
        return subprocess.Popen(
            [sys.executable, *arguments],
            env=self._environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )


def require_ros() -> None:
    """End the test where ROS is missing."""
    if find_spec("rospy") is None or find_spec("rosmaster") is None:
        lacking = "rospy or rosmaster is missing; scripts/bootstrap installs them where apt has them"
        (pytest.fail if os.environ.get("CI") else pytest.skip)(lacking)
