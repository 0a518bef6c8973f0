"""Tasks that processes of the tests import."""

import os
import signal
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any


def square(point: Mapping[str, Any]) -> dict[str, Any]:
    return {"square": point["x"] ** 2}


def noted(point: Mapping[str, Any]) -> dict[str, Any]:
    """Leaves a line for each time that a point is begun; one with a gate waits until that is there."""
    with Path(point["notes"]).open("a") as file:
        file.write(f"{point['x']} {os.getpid()}\n")
    time.sleep(point.get("seconds", 0.0))
    deadline = time.monotonic() + 60.0
    while "gate" in point and not Path(point["gate"]).exists() and time.monotonic() < deadline:
        time.sleep(0.01)
    return square(point)


def failing_at_three(point: Mapping[str, Any]) -> dict[str, Any]:
    if point["x"] == 3:
        raise ValueError("no threes")
    return square(point)


def dying_at_three(point: Mapping[str, Any]) -> dict[str, Any]:
    if point["x"] == 3:
        os.kill(os.getpid(), signal.SIGKILL)
    return square(point)


def not_finite(_point: Mapping[str, Any]) -> dict[str, Any]:
    return {"square": float("nan")}


def clashing(_point: Mapping[str, Any]) -> dict[str, Any]:
    return {"x": 0}
