"""A reference controller in a process of its own, with its operator's panel on standard input and output."""

import json
import signal
import subprocess
from collections.abc import Mapping, Sequence
from typing import Any

from beltsort.cell import within
from tests.waiting import PATIENCE


class PanelProcess:
    """The process, which has announced itself.

    Parameters
    ----------
    command
        The program and its arguments.
    environment
        Its environment; None for that of the tests.
    inherited
        File descriptors that it keeps open.

    Attributes
    ----------
    announced
        What it has announced.
    """

    def __init__(
        self,
        command: Sequence[str],
        environment: Mapping[str, str] | None = None,
        inherited: Sequence[int] = (),
    ) -> None:
        self._process = subprocess.Popen(
            command,
            env=environment,
            pass_fds=inherited,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        try:
            self.announced = self._heard()
        except BaseException:
            self.kill()
            raise

    def push(self, button: str) -> dict[str, Any]:
        """Push a button of the panel; return what it shows."""
        stdin = self._process.stdin
        assert stdin is not None
        stdin.write(f"{button}\n")
        stdin.flush()
        return self._heard()

    def hang(self) -> None:
        """Stop it (SIGSTOP)."""
        self._process.send_signal(signal.SIGSTOP)

    def resume(self) -> None:
        """Let it go on (SIGCONT)."""
        self._process.send_signal(signal.SIGCONT)

    def kill(self) -> None:
        """Kill it (SIGKILL)."""
        with self._process as process:  # closes its pipes, and waits
            process.kill()

    def left_alone(self) -> int:
        """Close its standard input; return its exit code."""
        stdin = self._process.stdin
        assert stdin is not None
        stdin.close()
        return self._process.wait(PATIENCE)

    def _heard(self) -> dict[str, Any]:
        stdout = self._process.stdout
        assert stdout is not None
        line: dict[str, Any] = json.loads(within(PATIENCE, "a line of the panel", stdout.readline))
        return line
