"""Every scan gets the camera's pose in the belt's frame, from whoever knows it best."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from beltsort.cell.commands import MoveTo
from beltsort.cell.placement import Placement
from beltsort.cell.protocols import Scan
from beltsort.cell.wrappers.layer import Layer, Request, ScanRequest, Send, Take
from beltsort.errors import CellError
from beltsort.geometry import Pose


class CameraPoses(Layer):
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

    def command(self, send: Send, request: Request) -> float:
        """Pass a command on; a move, and note where it ended."""
        if not isinstance(request.act, MoveTo):
            return send(request)
        self._reached = None
        stopped = send(request)
        self._reached = request.act.viewpoint
        return stopped

    def scan(self, take: Take, request: ScanRequest) -> Scan:
        """Return a scan with the camera's pose in the belt's frame."""
        scan, placement = take(request), self._placement
        if np.isfinite(scan.world_from_camera).all():
            return replace(scan, world_from_camera=placement.in_belt(scan.world_from_camera))
        flange = None if placement.flange_from_camera is None else self._flange_pose()
        pose = None if flange is None else placement.of_camera(flange)
        if pose is not None:
            return replace(scan, world_from_camera=pose)
        return replace(scan, world_from_camera=self._of_viewpoint(), assumed=True)

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
