"""Options of the node of a run: the table [ros2] of the cell file."""

import re
from dataclasses import dataclass

from beltsort.drivers.ros2.options import Ros2Options
from beltsort.errors import CellError

NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
"""Names of nodes."""


@dataclass(frozen=True, kw_only=True)
class NodeOptions(Ros2Options):
    """Options of the node of a run, also those of `Ros2Options`.

    Attributes
    ----------
    name
        The node's name, with which its topics and services begin.
    frame
        The tf frame that is the belt frame (`beltsort.geometry`).
    """

    name: str = "beltsort"
    frame: str = "belt"

    def __post_init__(self) -> None:
        """Check all options."""
        super().__post_init__()
        if NAME.fullmatch(self.name) is None:
            raise CellError(
                f"name is {self.name!r}, expected letters, digits and _, a letter first; give a name of ROS 2"
            )
        if not self.frame:
            raise CellError("frame is empty, expected the tf frame of the belt; give its name")
