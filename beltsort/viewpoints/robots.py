"""Robots by name; their URDFs come with the package `example-robot-data`."""

from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

from beltsort.errors import MissingExtraError, ViewpointError

PACKAGE = "example-robot-data"

ROBOTS = {
    "baxter": ("baxter.urdf", "left_hand_link"),
    "panda": ("panda.urdf", "panda_link8"),
    "ur5": ("ur5_robot.urdf", "tool0"),
}
"""File name of the URDF, and the flange that the camera is taken to sit at."""


def robot_urdf(name: str) -> tuple[Path, str]:
    """Return the URDF and the camera's frame of a robot.

    Raises
    ------
    ViewpointError
        If the name is unknown.
    MissingExtraError
        If the package is not installed.
    """
    if name not in ROBOTS:
        raise ViewpointError(f"there is no robot {name!r}; choose from {', '.join(ROBOTS)}, or give a URDF")
    file_name, tip = ROBOTS[name]
    try:
        files = distribution(PACKAGE).files or []
    except PackageNotFoundError as reason:
        raise MissingExtraError(
            f"{PACKAGE}, which has the URDF of {name}, is not installed; pip install 'beltsort[ik]'"
        ) from reason
    for file in files:
        if file.name == file_name:
            return Path(str(file.locate())), tip
    raise ViewpointError(f"{PACKAGE} has no {file_name} any more; give the URDF as a file")
