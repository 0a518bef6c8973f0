"""Tasks that processes of the tests import."""

import os
import signal
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tests.waiting import PATIENCE, wait_until


def square(point: Mapping[str, Any]) -> dict[str, Any]:
    return {"square": point["x"] ** 2}


def noted(point: Mapping[str, Any]) -> dict[str, Any]:
    """Leaves a line for each time that a point is begun; one with a gate waits until that is there."""
    with Path(point["notes"]).open("a") as file:
        file.write(f"{point['x']} {os.getpid()}\n")
    if "gate" in point:
        wait_until(Path(point["gate"]).exists, "the gate opens", timeout=10.0 * PATIENCE)
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
