"""A stand-in for systemd: it starts a unit's command, listens to it, kills it if it hangs, restarts it."""

import os
import re
import shlex
import signal
import socket
import subprocess
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

LISTEN = 0.05
"""Seconds for which the manager listens before it looks at the process again."""


@dataclass(frozen=True)
class Unit:
    """What the stand-in knows of a unit file."""

    command: list[str]
    folder: Path
    watchdog: float
    again: frozenset[int]
    never: frozenset[int]

    @classmethod
    def parse(cls, text: str) -> "Unit":
        values = dict(re.findall(r"^(\w+)=(.*)$", text, re.MULTILINE))
        assert (values["Type"], values["Restart"]) == ("notify", "on-failure")
        codes = [
            frozenset(map(int, values[f"Restart{kind}ExitStatus"].split())) for kind in ("Force", "Prevent")
        ]
        words = [word.replace("%%", "%").replace("$$", "$") for word in shlex.split(values["ExecStart"])]
        folder = Path(values["WorkingDirectory"].replace("%%", "%"))
        return cls(words, folder, float(values["WatchdogSec"]), *codes)

    def starts_again(self, code: int) -> bool:
        """Whether the command is started again; a negative code is that of a signal that killed it."""
        return code in self.again or (code != 0 and code not in self.never)


Launch = Callable[[Unit, dict[str, str]], "subprocess.Popen[bytes]"]


@dataclass
class Started:
    """One process of the unit."""

    process: "subprocess.Popen[bytes]"
    said: list[str] = field(default_factory=list)
    heard: float = 0.0
    """When the last sign of life came."""

    @property
    def ready(self) -> bool:
        return "READY=1" in self.said


def launch(unit: Unit, environment: dict[str, str]) -> "subprocess.Popen[bytes]":
    """Start a unit's command; what it says goes to a file in its folder."""
    with (unit.folder / "service.log").open("a") as log:
        return subprocess.Popen(
            unit.command, cwd=unit.folder, env=environment, stdin=subprocess.DEVNULL, stdout=log, stderr=log
        )


class Manager:
    """Runs a unit.

    Parameters
    ----------
    unit
        The unit.
    patience
        Seconds without a sign of life after which a process that was ready is killed; those of the unit by
        default, which the process is told in any case.
    launch
        Starts the command in an environment.
    """

    def __init__(self, unit: Unit, patience: float | None = None, launch: Launch = launch) -> None:
        self._unit, self._patience = unit, unit.watchdog if patience is None else patience
        self._launch = launch
        self.starts: list[Started] = []
        self.codes: list[int] = []
        self.hung = 0

    def run(self, meddle: Callable[[Started], None] = lambda _started: None) -> int:
        """Run until the unit is not started again, and return its last exit code.

        `meddle` is called again and again with the process.
        """
        address = self._unit.folder / "notify"
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as heard:
            address.unlink(missing_ok=True)
            heard.bind(str(address))
            heard.settimeout(LISTEN)
            environment = {
                **os.environ,
                "NOTIFY_SOCKET": str(address),
                "WATCHDOG_USEC": str(int(1e6 * self._unit.watchdog)),
            }
            while True:
                process = self._launch(self._unit, environment)
                started = Started(process)
                self.starts.append(started)
                try:
                    self._attend(started, heard, meddle)
                finally:
                    process.kill()
                    self.codes.append(process.wait())
                if not self._unit.starts_again(self.codes[-1]):
                    return self.codes[-1]

    def _attend(self, started: Started, heard: socket.socket, meddle: Callable[[Started], None]) -> None:
        while started.process.poll() is None:
            with suppress(TimeoutError):
                started.said += heard.recv(65_536).decode().split("\n")
                started.heard = time.monotonic()
            if started.ready and time.monotonic() - started.heard > self._patience:
                self.hung += 1
                started.process.send_signal(signal.SIGKILL)
                started.process.wait()
            meddle(started)
