"""Correction of the camera's pose by the belt plane that a scan shows.

The belt is the plane z = 0 of the world. An arm's error of 0.5 degrees lifts a rim 0.7 m away by 6 mm, more
than the margin between rim and object. The visible belt corrects height and tilt, but not x, y and heading.
"""

import numpy as np
from numpy.typing import NDArray

from beltsort.geometry import Points, Pose, transform

SAMPLES = 20_000
BANDS = (0.03, 0.008, 0.005)  # metres about the plane found so far; each pass fits what lies inside
REACH = 10.0  # metres from the belt end; farther points are not the belt, and make the fit ill-conditioned
NOISE = 0.003  # metres
PRIOR_HEIGHT = 0.01  # metres
PRIOR_SLOPE = 0.02  # metres per metre


def levelled(points: Points, world_from_camera: Pose) -> Pose:
    """Return `world_from_camera`, shape (4, 4), rotated and lifted so that the seen belt lies in z = 0.

    The plane z = a x + b y + c minimises the squared residuals of the points near it plus the squares of
    a, b, c over those of the expected pose errors: little or no visible belt leaves the reported pose.
    The bands get narrower, so that the walls of cups are left out.

    Parameters
    ----------
    points
        Shape (n, 3), camera frame, metres; points that are not finite are ignored.
    world_from_camera
        The pose that the arm reports, shape (4, 4).
    """
    sample = points[:: max(1, len(points) // SAMPLES)]
    x, y, z = sample.T
    world = transform(world_from_camera, sample[np.isfinite(x + y + z)])
    x, y, z = np.abs(world.T)
    world = world[(x < REACH) & (y < REACH) & (z < BANDS[0])]
    design = np.column_stack([world[:, :2], np.ones(len(world))])
    plane: NDArray[np.float64] = np.zeros(3)
    for band in BANDS:
        near = np.abs(world[:, 2] - design @ plane) < band
        plane = _fit(design[near], world[near, 2])
    return _lay_flat(plane) @ world_from_camera


def _fit(design: NDArray[np.float64], heights: NDArray[np.float64]) -> NDArray[np.float64]:
    prior = np.diag([PRIOR_SLOPE**-2, PRIOR_SLOPE**-2, PRIOR_HEIGHT**-2])
    return np.asarray(np.linalg.solve(design.T @ design / NOISE**2 + prior, design.T @ heights / NOISE**2))


def _lay_flat(plane: NDArray[np.float64]) -> Pose:
    """Return the rigid transform that turns z = a x + b y + c into z = 0 the shortest way, shape (4, 4)."""
    normal = np.array([-plane[0], -plane[1], 1.0])
    normal /= np.linalg.norm(normal)
    x, y, z = normal
    pose = np.eye(4)
    pose[:3, :3] = [
        [1.0 - x * x / (1.0 + z), -x * y / (1.0 + z), -x],
        [-x * y / (1.0 + z), 1.0 - y * y / (1.0 + z), -y],
        [x, y, z],
    ]
    pose[2, 3] = -plane[2] * z
    return pose
