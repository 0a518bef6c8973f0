"""Transforms between the robot's world frame, used by drivers, and the belt frame, used by the cell."""

from dataclasses import dataclass

import numpy as np

from beltsort.geometry import Pose


@dataclass(frozen=True, eq=False)
class Placement:
    """The poses of the belt in the robot's world frame, and of the camera on the flange.

    Attributes
    ----------
    world_from_belt
        Pose of the belt frame in the robot's world frame, shape (4, 4); None if they are the same.
    flange_from_camera
        The hand-eye transform, shape (4, 4); None if it is not known.

    Examples
    --------
    A belt 0.5 m in front of the robot, a camera 0.1 m ahead of the flange:

    >>> from beltsort.cell.frames import from_quaternion
    >>> no_turn = (0.0, 0.0, 0.0, 1.0)
    >>> belt, hand_eye = (from_quaternion(at, no_turn) for at in ((0.5, 0.0, 0.0), (0.0, 0.0, 0.1)))
    >>> placement = Placement(belt, hand_eye)
    >>> camera = placement.of_camera(from_quaternion((0.5, 0.0, 0.6), no_turn))
    >>> camera[:3, 3].tolist()
    [0.0, 0.0, 0.7]
    >>> placement.of_flange(camera)[:3, 3].round(12).tolist()
    [0.5, 0.0, 0.6]
    """

    world_from_belt: Pose | None = None
    flange_from_camera: Pose | None = None

    def in_belt(self, pose: Pose) -> Pose:
        """Transform a pose from the robot's world frame to the belt frame, shape (4, 4)."""
        if self.world_from_belt is None:
            return pose
        there: Pose = np.linalg.inv(self.world_from_belt) @ pose
        return there

    def in_world(self, pose: Pose) -> Pose:
        """Transform a pose from the belt frame to the robot's world frame, shape (4, 4)."""
        return pose if self.world_from_belt is None else self.world_from_belt @ pose

    def of_camera(self, world_from_flange: Pose) -> Pose | None:
        """Return the camera's pose in the belt's frame, shape (4, 4), or None without a hand-eye transform.

        Parameters
        ----------
        world_from_flange
            The flange's pose in the robot's world, shape (4, 4).
        """
        hand_eye = self.flange_from_camera
        return None if hand_eye is None else self.in_belt(world_from_flange @ hand_eye)

    def of_flange(self, belt_from_camera: Pose) -> Pose | None:
        """Return the flange's pose in the robot's world, shape (4, 4), or None without a hand-eye transform.

        For arms that are commanded by poses, since viewpoints are poses of the camera in the belt frame.

        Parameters
        ----------
        belt_from_camera
            The camera's pose in the belt's frame, shape (4, 4).
        """
        hand_eye = self.flange_from_camera
        return None if hand_eye is None else self.in_world(belt_from_camera) @ np.linalg.inv(hand_eye)
