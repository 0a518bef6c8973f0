"""A peer in a process of its own, stopped by its process id, and the devices that talk to it."""

import json
import os
import signal
import subprocess
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from pathlib import Path
from typing import Any, ClassVar

import pytest

from beltsort.cell import CommandError, within
from beltsort.drivers.ros.arm import RosArm
from beltsort.drivers.ros.belt import RosBelt
from beltsort.drivers.ros.camera import RosCamera
from beltsort.drivers.ros.device import RosDevice
from beltsort.drivers.ros.sorter import RosSorter
from tests.waiting import PATIENCE, wait_until

ON_THE_WAY = 0.2
"""Seconds within which what was sent has arrived."""


class PeerRig(ABC):
    """Starts, freezes and kills a peer that runs `tests.drivers.ros.machine`."""

    peer: subprocess.Popen[str]
    node_program: ClassVar[str]
    """Part of the command line of the nodes of our devices."""
    connecting: str
    """A program that connects a belt."""

    def __init__(self, environment: dict[str, str], *inherited: int) -> None:
        self._environment, self._inherited = environment, inherited

    @abstractmethod
    def start_peer(self) -> subprocess.Popen[str]:
        """Start a peer, and return it when it is ready."""

    @abstractmethod
    def mend(self) -> None:
        """See to it that the peer runs and does what it does at first."""

    @abstractmethod
    def close(self) -> None:
        """End the peer."""

    @abstractmethod
    def arm(self, *, action: bool = False, **changes: Any) -> RosArm:
        """Return a device for the arm, by topic or action, with changes to its options."""

    @abstractmethod
    def camera(self, *, by_joints: bool = False, **changes: Any) -> RosCamera:
        """Return a device for the camera, which knows its pose from tf or joint positions."""

    @abstractmethod
    def belt(self) -> RosBelt:
        """Return a device for the belt."""

    @abstractmethod
    def sorter(self) -> RosSorter:
        """Return a device for the sorter."""

    @abstractmethod
    def hanging_belt(self, folder: Path, patch: pytest.MonkeyPatch) -> RosBelt:
        """Return a belt whose node never gets ready."""

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

    def kill(self, process: subprocess.Popen[str]) -> None:
        process.kill()
        process.wait()

    def freeze(self) -> None:
        """Stop the peer, and let arrive what it has sent: it is older than the commands after it."""
        os.kill(self.peer.pid, signal.SIGSTOP)
        time.sleep(ON_THE_WAY)

    def thaw(self) -> None:
        os.kill(self.peer.pid, signal.SIGCONT)

    def _started(self, *command: str) -> subprocess.Popen[str]:
        """Start a peer, and return it when it is ready."""
        self.peer = self._start(*command)
        assert self.peer.stdout is not None
        assert within(PATIENCE, "the peer's start", self.peer.stdout.readline) == "ready\n"
        return self.peer

    def _start(self, *command: str) -> subprocess.Popen[str]:
        return subprocess.Popen(
            command,
            env=self._environment,
            pass_fds=self._inherited,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )


def await_ready(device: RosDevice) -> None:
    """Wait until the nodes of a device and of its peer have found each other."""

    def ready() -> bool:
        try:
            return device.health().ready
        except CommandError:  # master or peer took longer than a device allows them
            return False

    wait_until(ready, f"{device.address} is ready")
