"""Checks of options."""

from collections.abc import Mapping, Sequence

import numpy as np

from beltsort.drivers.ros.joints import Joints
from beltsort.errors import CellError
from beltsort.geometry import Pose

ROUNDING = 1e-3
"""Tolerance of the orthogonality of a rotation."""


def check_positive(options: object, *names: str) -> None:
    """Check that numbers are finite and above 0.

    Examples
    --------
    >>> check_positive(complex(1.0, -2.0), "real", "imag")
    Traceback (most recent call last):
    ...
    beltsort.errors.CellError: imag is -2.0, expected above 0 and finite; start from the default
    """
    for name in names:
        value = getattr(options, name)
        if not 0.0 < value < np.inf:
            raise CellError(f"{name} is {value}, expected above 0 and finite; start from the default")


def check_taught(taught: Mapping[str, Joints]) -> None:
    """Check that all viewpoints have finite positions of the same joints, at least one."""
    for name, joints in taught.items():
        expected = set(next(iter(taught.values())))
        if not joints or set(joints) != expected or not np.isfinite(list(joints.values())).all():
            raise CellError(
                f"taught.{name} is {dict(joints)}, expected a finite position for each of the joints "
                f"{sorted(expected) or 'of the arm'}; teach it again"
            )


def check_pose(name: str, rows: Sequence[Sequence[float]]) -> Pose:
    """Return a pose as an array, shape (4, 4), after checking that it is a rigid transform."""
    try:
        pose: Pose = np.array(rows, dtype=np.float64).reshape(4, 4)
    except ValueError:
        pose = np.zeros((4, 4))
    rotation = pose[:3, :3]
    orthogonal = np.allclose(rotation @ rotation.T, np.eye(3), atol=ROUNDING)
    right_handed = orthogonal and np.linalg.det(rotation) > 0.0
    if not right_handed or not np.isfinite(pose).all() or pose[3].tolist() != [0.0, 0.0, 0.0, 1.0]:
        raise CellError(
            f"{name} is {rows}, expected a rigid transform of shape (4, 4): give a right-handed rotation, a "
            "position in metres, and the last row 0, 0, 0, 1"
        )
    return pose
