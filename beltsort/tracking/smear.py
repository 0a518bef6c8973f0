"""Correction of scans that were taken while the belt moved."""

from dataclasses import replace

import numpy as np

from beltsort.cell.protocols import Scan
from beltsort.errors import TrackingError
from beltsort.tracking.motion import BeltMotion


def without_smear(scan: Scan, motion: BeltMotion, exposure: float) -> Scan:
    """Return a scan with each point where it was in the middle of the exposure.

    A camera that reads its rows one after the other sees an object in row r of R where it is at
    t_r = stamp + (r + 1/2) / R exposure. The object moves with the belt, so that its points are displaced by
    travel(t_r) - travel(middle), along x. The camera must stand still; what its own motion smears is not
    corrected.

    Parameters
    ----------
    scan
        An organised scan, points of shape (height, width, 3), its pose in the belt frame. Rows are exposed
        from top to bottom.
    motion
        The belt's motion; must reach to the end of the exposure.
    exposure
        Seconds from the first row to the last.

    Raises
    ------
    TrackingError
        If the exposure is negative, the scan is not organised, or nothing is known about the belt's travel at
        that time.
    """
    if not 0.0 <= exposure < np.inf:
        raise TrackingError(f"exposure is {exposure}, expected a finite number of seconds of at least 0")
    if scan.points.ndim != 3:
        raise TrackingError(
            f"the scan's points have shape {scan.points.shape}, expected (height, width, 3): the time of a "
            "point is told by its row; give an exposure of 0 for a camera that exposes all of them at once"
        )
    rows = scan.points.shape[0]
    times = scan.stamp + (np.arange(rows) + 0.5) / rows * exposure
    middle = motion.travel(scan.stamp + exposure / 2.0).metres
    ahead = np.array([motion.travel(time).metres for time in times.tolist()]) - middle  # (height,)
    upstream = scan.world_from_camera[0, :3]  # world x in the camera frame
    return replace(scan, points=scan.points + (ahead[:, None] * upstream)[:, None, :])
