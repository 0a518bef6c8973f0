"""The deviation of the camera's pose from its viewpoint."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from beltsort.cell.diverting import DivertingCell
from beltsort.cell.protocols import Cell, KnowsPoses, Scan
from beltsort.geometry import Pose


@dataclass(frozen=True)
class Deviation:
    """The difference of two poses.

    Attributes
    ----------
    angle
        Angle of the rotation between them, degrees.
    distance
        Distance of their origins, millimetres.
    """

    angle: float
    distance: float

    def exceeds(self, angle: float, distance: float) -> bool:
        """Whether the deviation exceeds an angle, degrees, or a distance, millimetres."""
        return self.angle > angle or self.distance > distance


def deviation(pose: Pose, expected: Pose) -> Deviation:
    """Return the deviation of one pose, shape (4, 4), from another.

    Examples
    --------
    >>> from beltsort.cell.frames import from_quaternion
    >>> deviation(from_quaternion((0.0, 0.0, 0.02), (0.0, 0.0, 1.0, 0.0)), np.eye(4))
    Deviation(angle=180.0, distance=20.0)
    """
    turn = expected[:3, :3].T @ pose[:3, :3]
    cosine = float(np.clip((np.trace(turn) - 1.0) / 2.0, -1.0, 1.0))
    offset = float(np.linalg.norm(pose[:3, 3] - expected[:3, 3]))
    return Deviation(float(np.degrees(np.arccos(cosine))), 1000.0 * offset)


def viewpoint_poses(cell: Cell | DivertingCell) -> Sequence[Pose | None]:
    """Return the camera's pose at each viewpoint, None if the cell does not know it."""
    known = cell.poses if isinstance(cell, KnowsPoses) else ()
    return known or [None] * len(cell.viewpoints)


def deviation_from(expected: Pose | None, scan: Scan) -> Deviation | None:
    """Return the deviation of a scan's camera pose from a viewpoint's; None if one is not known."""
    return None if expected is None or scan.assumed else deviation(scan.world_from_camera, expected)
