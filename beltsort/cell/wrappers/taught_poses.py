"""Scans of a camera that does not know where it stands get the pose that was taught for it."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from beltsort.cell.protocols import Scan
from beltsort.cell.wrappers.wrapped import Act, Call
from beltsort.errors import CellError
from beltsort.geometry import Pose


class TaughtPoses:
    """Fills in where the camera stands: at the viewpoint that the arm reached last. One for arm and camera.

    A camera that knows its pose (from a robot's driver, say) tells it, and keeps it. One that does not
    returns a `world_from_camera` of NaN.

    Parameters
    ----------
    viewpoints
        Names of the viewpoints.
    poses
        `world_from_camera` of each, shape (4, 4), or None where only joint angles were taught.
    """

    def __init__(self, viewpoints: Sequence[str], poses: Sequence[Pose | None]) -> None:
        self._viewpoints, self._poses = viewpoints, poses
        self._reached: int | None = None

    def __call__(self, call: Call, act: Act) -> Any:
        """Pass the call on."""
        if call.name == "move_to":
            self._reached = None
        result = act(call)
        if call.name == "move_to":
            self._reached = int(call.target or 0)
        if isinstance(result, Scan) and not np.isfinite(result.world_from_camera).all():
            return replace(result, world_from_camera=self._pose())
        return result

    def _pose(self) -> Pose:
        if self._reached is None:
            raise CellError(
                "the camera does not tell its pose and the arm has reached no viewpoint; move to one first"
            )
        pose = self._poses[self._reached]
        if pose is None:
            raise CellError(
                f"the camera does not tell its pose and viewpoint {self._viewpoints[self._reached]} has only "
                "joint angles; add the pose to the cell file, by position and quaternion for example"
            )
        return pose
