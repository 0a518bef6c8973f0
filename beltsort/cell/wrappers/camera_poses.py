"""Every scan gets the camera's pose in the belt's frame, from whoever knows it best."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from beltsort.cell.placement import Placement
from beltsort.cell.protocols import Scan
from beltsort.cell.wrappers.wrapped import Act, Call
from beltsort.errors import CellError
from beltsort.geometry import Pose


class CameraPoses:
    """Tells where the camera stood, in the belt's frame. One for arm and camera.

    1. A camera that knows its pose tells it, in the robot's world. One that does not returns NaN.
    2. Then the arm is asked where its flange is, after the scan: it stands still until its next command.
    3. If it does not know, or there is no hand-eye transform, the pose is taken to be that of the viewpoint
       which the arm reached last.

    Parameters
    ----------
    viewpoints
        Names of the viewpoints.
    poses
        The camera's pose at each in the belt's frame, shape (4, 4), or None where only joint angles were
        taught.
    placement
        Of belt and camera.
    flange_pose
        Asks the arm: see `beltsort.cell.protocols.TellsFlangePose`.
    """

    def __init__(
        self,
        viewpoints: Sequence[str],
        poses: Sequence[Pose | None],
        placement: Placement,
        flange_pose: Callable[[], Pose | None],
    ) -> None:
        self._viewpoints, self._poses = viewpoints, poses
        self._placement, self._flange_pose = placement, flange_pose
        self._reached: int | None = None

    def __call__(self, call: Call, act: Act) -> Any:
        """Pass the call on."""
        if call.name == "move_to":
            self._reached = None
        result = act(call)
        if call.name == "move_to":
            self._reached = int(call.target or 0)
        return self._placed(result) if isinstance(result, Scan) else result

    def _placed(self, scan: Scan) -> Scan:
        if np.isfinite(scan.world_from_camera).all():
            return replace(scan, world_from_camera=self._placement.in_belt(scan.world_from_camera))
        told = self._told_by_the_arm()
        if told is not None:
            return replace(scan, world_from_camera=told)
        return replace(scan, world_from_camera=self._of_viewpoint(), assumed=True)

    def _told_by_the_arm(self) -> Pose | None:
        if self._placement.flange_from_camera is None:
            return None
        flange = self._flange_pose()
        return None if flange is None else self._placement.of_camera(flange)

    def _of_viewpoint(self) -> Pose:
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
