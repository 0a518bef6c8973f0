"""A peer in a process of its own, stopped by its process id."""

import json
import os
import signal
import subprocess
import threading
import time
from collections.abc import Callable
from typing import Any

from beltsort.cell import within
from tests.waiting import PATIENCE, wait_until

ON_THE_WAY = 0.2
"""Seconds within which what was sent has arrived."""


class PeerRig:
    """Starts, freezes and kills a peer that runs `tests.drivers.ros.machine`."""

    peer: subprocess.Popen[str]

    def __init__(self, environment: dict[str, str]) -> None:
        self._environment = environment

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
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )
