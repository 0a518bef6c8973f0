"""Rotations from rotation vectors."""

import numpy as np
from numpy.typing import ArrayLike

from beltsort.geometry import Points


def rotation(vector: ArrayLike) -> Points:
    """Return the rotation matrix of a rotation vector, radians (Rodrigues' formula), shape (3, 3)."""
    x, y, z = np.asarray(vector, dtype=np.float64)
    angle = np.sqrt(x * x + y * y + z * z)
    if angle == 0.0:
        return np.eye(3)
    axis = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]) / angle
    turn: Points = np.eye(3) + np.sin(angle) * axis + (1.0 - np.cos(angle)) * axis @ axis
    return turn
