"""What a robot cell is: an arm that carries a depth camera, a belt, and a sorter.

Every call blocks until the act is done. A command carries an id, unique in a run; repeating a command with
the same id acts only once. Belt targets are absolute: "object n at the belt end", never "one step further".
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from beltsort.geometry import BeltLayout, Points, Pose


@dataclass(frozen=True)
class Scan:
    """What the depth camera returns.

    Attributes
    ----------
    points
        Points in the *camera* frame, metres: (height, width, 3) for an organised depth image, NaN where a
        pixel has no return, or (n, 3).
    world_from_camera
        The camera's pose as the arm reports it, shape (4, 4).
    stamp
        Time at which the exposure began, seconds on the cell's clock.
    frame
        Name of the camera frame.
    """

    points: Points
    world_from_camera: Pose
    stamp: float
    frame: str = "camera"


class Arm(Protocol):
    """Carries the camera."""

    def move_to(self, viewpoint: int, command_id: str) -> float:
        """Bring the camera to `viewpoint`; return the time of its stop, seconds on the cell's clock."""


class DepthCamera(Protocol):
    """Takes scans."""

    def scan(self, *, not_before: float) -> Scan:
        """Return a scan whose exposure began at or after `not_before` (seconds on the cell's clock)."""


class Belt(Protocol):
    """Carries the objects."""

    def advance_to(self, index: int, command_id: str) -> float:
        """Bring object number `index` of the run to the belt end; return the time of its stop there.

        Seconds on the cell's clock.
        """


class Sorter(Protocol):
    """Puts the object at the belt end into a bin."""

    def sort(self, label: int, command_id: str) -> None:
        """Put the object at the belt end into the bin of class `label`, or into the cell's `reject_bin`."""


class Cell(Arm, DepthCamera, Belt, Sorter, Protocol):
    """Arm, camera, belt and bins as one."""

    @property
    def classes(self) -> Sequence[str]:
        """Names of the object classes, one bin each."""

    @property
    def viewpoints(self) -> Sequence[str]:
        """Names of the viewpoints."""

    @property
    def layout(self) -> BeltLayout:
        """The belt's geometry."""

    @property
    def reject_bin(self) -> int | None:
        """The bin for undecided objects, or None if the cell has none."""
