"""The camera's pose in the belt frame, from the best source available."""

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
    """Adds the camera's pose in the belt frame to each scan. Arm and camera share one instance.

    1. If the camera reports its pose in the robot's world frame (other than NaN), that is transformed.
    2. Otherwise the arm is asked for the pose of its flange after the scan, as it does not move until its
       next command.
    3. If the arm does not know it, or there is no hand-eye transform, the pose is assumed to be that of the
       viewpoint that the arm reached last.

    Parameters
    ----------
    viewpoints
        Names of the viewpoints.
    poses
        The camera's pose at each viewpoint in the belt frame, shape (4, 4), or None if only joint angles were
        taught.
    placement
        Placement of belt and camera.
    flange_pose
        Asks the arm for the pose of its flange: see `beltsort.cell.protocols.TellsFlangePose`.
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
        """Pass a command on, and remember the viewpoint that a move reached."""
        if not isinstance(request.act, MoveTo):
            return send(request)
        self._reached = None
        stopped = send(request)
        self._reached = request.act.viewpoint
        return stopped

    def scan(self, take: Take, request: ScanRequest) -> Scan:
        """Return a scan with the camera's pose in the belt frame."""
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
