"""Waiting for what another thread or process does."""

import time
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

Result = TypeVar("Result")

PATIENCE = 120.0
"""Seconds after which a test that still waits has failed; a busy machine is given all of them."""

BETWEEN_LOOKS = 0.01


def wait_until(condition: Callable[[], Result | None], what: str, timeout: float = PATIENCE) -> Result:
    """Ask again and again until the answer is true, and return that answer; `what` names what is awaited."""
    end = time.monotonic() + timeout
    while not (answer := condition()):
        assert time.monotonic() < end, f"waited {timeout:g} s in vain: {what}"
        time.sleep(BETWEEN_LOOKS)
    return answer


def alive(pid: int) -> bool:
    """Tell whether a thread of a process runs; one that nobody has asked for its exit code yet does not.

    A process that was killed can only be asked for its exit code once all of its threads have ended, of which
    the first may be the first to end.
    """
    try:
        return any(_runs(thread) for thread in Path(f"/proc/{pid}/task").iterdir())
    except (FileNotFoundError, ProcessLookupError):
        return False


def _runs(thread: Path) -> bool:
    try:
        state = (thread / "stat").read_text().rpartition(")")[2].split()[0]
    except (FileNotFoundError, ProcessLookupError):
        return False
    return state not in "ZX"
