"""Poses given as a matrix, or as a position and a quaternion."""

from collections.abc import Sequence

import numpy as np

from beltsort.geometry import Pose

ROUNDING = 1e-3  # largest error of a rotation that is given; it is made exact


def from_quaternion(position: Sequence[float], quaternion: Sequence[float]) -> Pose:
    """Return the rigid transform of a position, metres, and a quaternion (x, y, z, w), shape (4, 4).

    Raises
    ------
    ValueError
        If the quaternion is not of length 1.

    Examples
    --------
    >>> half_turn_about_z = from_quaternion((0.1, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0))
    >>> half_turn_about_z[:3, 0].tolist()
    [-1.0, 0.0, 0.0]
    """
    length = float(np.linalg.norm(quaternion))
    if not abs(length - 1.0) < ROUNDING:
        raise ValueError(
            f"quaternion {list(quaternion)} has length {length:.4g}, expected 1: give x, y, z, w in order"
        )
    x, y, z, w = np.asarray(quaternion, dtype=np.float64) / length
    pose = np.eye(4)
    pose[:3, :3] = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
        [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
        [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
    ]
    pose[:3, 3] = position
    return pose


def from_matrix(rows: Sequence[Sequence[float]]) -> Pose:
    """Return the rigid transform of a matrix, shape (4, 4), with its rotation made exact.

    Raises
    ------
    ValueError
        If the matrix is not a rigid transform.
    """
    pose = np.array(rows, dtype=np.float64)
    u, _, v = np.linalg.svd(pose[:3, :3])
    rotation = u @ v
    wrong = np.abs(rotation - pose[:3, :3]).max() > ROUNDING or np.linalg.det(rotation) < 0.0
    if wrong or pose[3].tolist() != [0.0, 0.0, 0.0, 1.0]:
        raise ValueError(
            f"matrix {pose.tolist()} is no rigid transform, expected a right-handed rotation, a position in "
            "metres and the last row 0, 0, 0, 1: check units, signs and the order of rows"
        )
    pose[:3, :3] = rotation
    return pose
