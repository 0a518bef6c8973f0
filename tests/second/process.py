"""The controller in C: how it is built and started."""

import os
import queue
import signal
import subprocess
import threading
from pathlib import Path

import pytest

from tests.waiting import PATIENCE

SPEED = 8
SOURCES = [Path(__file__).with_name(name) for name in ("controller.c", "diversions.c")]


def built(folder: Path) -> Path:
    """Build the controller in a folder; return the program."""
    if not Path("/usr/include/modbus/modbus.h").exists() and "CI" not in os.environ:
        pytest.skip("libmodbus is missing; on Debian or Ubuntu: apt-get install libmodbus-dev")
    path = folder / "controller"
    flags = ["-O1", "-Wall", "-Wextra", "-Werror"]
    subprocess.run(["cc", *flags, "-o", str(path), *map(str, SOURCES), "-lmodbus", "-lm"], check=True)
    return path


class Controller:
    """The controller's process. Its world is in a file and outlives it.

    Parameters
    ----------
    binary
        The program.
    folder
        Where its world is.
    belt
        Arguments of a belt that never stops.
    """

    def __init__(self, binary: Path, folder: Path, *belt: str) -> None:
        self._command, self._belt = [str(binary), str(folder / "world"), str(SPEED)], belt
        self.port = 0
        self.start()

    def start(self) -> None:
        self._process = subprocess.Popen(
            [*self._command, str(self.port), *self._belt],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        self.lines: queue.Queue[str] = queue.Queue()
        threading.Thread(target=self._read, args=(self._process, self.lines), daemon=True).start()
        word, number = self.lines.get(timeout=PATIENCE).split()
        assert word == "listening"
        self.port = int(number)

    @staticmethod
    def _read(process: subprocess.Popen[str], lines: "queue.Queue[str]") -> None:
        assert process.stdout is not None
        for line in process.stdout:
            lines.put(line.strip())

    def say(self, *lines: str) -> None:
        assert self._process.stdin is not None
        for line in lines:
            self._process.stdin.write(f"{line}\n")
        self._process.stdin.flush()

    def kill(self) -> None:
        self._process.kill()
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            assert pipe is not None
            pipe.close()

    def pause(self) -> None:
        self._process.send_signal(signal.SIGSTOP)

    def go_on(self) -> None:
        self._process.send_signal(signal.SIGCONT)
