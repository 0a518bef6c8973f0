"""Taught joint positions of viewpoints, and the viewpoint at which an arm stands."""

from collections.abc import Mapping
from typing import Any, TypeAlias

from beltsort.errors import CellError

Joints: TypeAlias = Mapping[str, float]
"""Position of each joint, radians or metres, by name."""


def distance(target: Joints, reported: Joints) -> float:
    """Return the largest deviation of a joint from its target, in the joint's unit.

    Raises
    ------
    CellError
        If a joint of the target is not reported.

    Examples
    --------
    >>> distance({"shoulder": 0.5, "elbow": 1.0}, {"shoulder": 0.5, "elbow": 1.25, "gripper": 0.0})
    0.25
    """
    missing = sorted(target.keys() - reported.keys())
    if missing:
        raise CellError(
            f"the joint states lack {', '.join(missing)} (they name {', '.join(reported) or 'none'}), "
            "expected every joint that was taught; correct the names"
        )
    return max(abs(reported[name] - position) for name, position in target.items())


def standing_at(taught: Mapping[str, Joints], reported: Joints, tolerance: float) -> str | None:
    """Return the viewpoint nearest to the reported joints; None if none is within `tolerance`."""
    name = min(taught, key=lambda viewpoint: distance(taught[viewpoint], reported))
    return name if distance(taught[name], reported) <= tolerance else None


def joints_text(joints: Joints) -> str:
    """Return joint positions as text."""
    return ", ".join(f"{name} {position:.4f}" for name, position in joints.items())


def joints_of(message: Mapping[str, Any]) -> dict[str, float]:
    """Return the positions of a sensor_msgs/JointState by joint."""
    return dict(zip(message["name"], message["position"], strict=False))
