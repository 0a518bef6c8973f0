"""The hand-eye transform, from poses of the flange and of the belt relative to the camera.

With A the motion of the flange between two poses, B that of the camera and X = `flange_from_camera`,

    A X = X B,

that is R_A R_X = R_X R_B and (R_A - 1) t_X = R_X t_B - t_A [1]_.

References
----------
.. [1] F. C. Park, B. J. Martin, "Robot sensor calibration: solving AX = XB on the Euclidean group", IEEE
   Transactions on Robotics and Automation 10 (1994) 717-721.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from beltsort.cell.arrival import deviation
from beltsort.errors import CellError
from beltsort.extrinsics.belt_pose import closed_form, determine_direction
from beltsort.extrinsics.scans import MarkedScan
from beltsort.geometry import Pose, inverse
from beltsort.util.extras import extra

with extra("perception"):
    from scipy.spatial.transform import Rotation

FEWEST_POSES = 3
LEAST_TURN = 5.0  # degrees, root mean square, about each of two axes
STOP_ANGLE, STOP_DISTANCE = 0.05, 0.5  # degrees, mm; poses that differ by less are of an arm that stood


def hand_eye_of(scans: Sequence[MarkedScan]) -> Pose:
    """Return `flange_from_camera`, shape (4, 4), in closed form.

    Parameters
    ----------
    scans
        With the poses of the flange. Those of one pose together show marks at two places, or are not used.

    Raises
    ------
    CellError
        If the poses do not determine it.
    """
    stops: list[list[MarkedScan]] = []
    for scan in scans:
        for stop in stops:
            if not deviation(scan.pose, stop[0].pose).exceeds(STOP_ANGLE, STOP_DISTANCE):
                stop.append(scan)
                break
        else:
            stops.append([scan])
    complete = [stop for stop in stops if determine_direction(stop)]
    if len(complete) < FEWEST_POSES:
        raise CellError(
            f"{len(complete)} of {len(stops)} poses of the flange show marks at two places, expected at "
            f"least {FEWEST_POSES}: scan from more poses, better 10, with an object at each place, or one "
            "that is moved while the arm stands"
        )
    camera_from_belt = [closed_form([replace(scan, pose=np.eye(4)) for scan in stop]) for stop in complete]
    return park_martin([stop[0].pose for stop in complete], camera_from_belt)


def park_martin(world_from_flange: Sequence[Pose], camera_from_target: Sequence[Pose]) -> Pose:
    """Return X = `flange_from_camera`, shape (4, 4), from three or more pairs of poses.

    With rotation vectors a and b of the motions, R_X minimises sum |a - R_X b|^2: it is (M^T M)^(-1/2) M^T
    with M = sum b a^T, here by singular values, since M has rank 2 if all axes lie in a plane. Then t_X is
    the least-squares solution of (R_A - 1) t_X = R_X t_B - t_A. All pairs of poses are used.

    Raises
    ------
    CellError
        If the flange turns about one axis only, or hardly at all.
    """
    pairs = list(combinations(range(len(world_from_flange)), 2))
    flange = [inverse(world_from_flange[j]) @ world_from_flange[i] for i, j in pairs]  # A
    camera = [camera_from_target[j] @ inverse(camera_from_target[i]) for i, j in pairs]  # B
    a, b = (
        Rotation.from_matrix([motion[:3, :3] for motion in motions]).as_rotvec()
        for motions in (flange, camera)
    )
    turns = np.degrees(np.linalg.svd(a, compute_uv=False)) / np.sqrt(len(pairs))
    if len(turns) < 2 or turns[1] < LEAST_TURN:
        raise CellError(
            f"about a second axis the flange turns by {turns[1:2].sum():.2g} degrees, expected "
            f"{LEAST_TURN:g} or more: poses that differ by translations and turns about one axis do not "
            "determine the hand-eye transform; scan from all sides, and with the camera turned about its "
            "optical axis"
        )
    u, _, vt = np.linalg.svd(b.T @ a)
    rotation = vt.T @ np.diag([1.0, 1.0, np.linalg.det(vt.T @ u.T)]) @ u.T
    equations = np.vstack([motion[:3, :3] - np.eye(3) for motion in flange])
    right = [rotation @ of_b[:3, 3] - of_a[:3, 3] for of_a, of_b in zip(flange, camera, strict=True)]
    found = np.eye(4)
    found[:3, :3] = rotation
    found[:3, 3] = np.linalg.lstsq(equations, np.concatenate(right), rcond=None)[0]
    return found
