"""A buffer of tf transforms."""

from collections import deque
from collections.abc import Sequence

import numpy as np

from beltsort.cell.frames import from_quaternion
from beltsort.errors import CellError
from beltsort.geometry import Pose

HISTORY = 10.0
"""Time for which transforms are kept, seconds."""

QUATERNION_SLACK = 1e-3
"""Tolerance of the length of a quaternion, which should be 1."""


class Frames:
    """Poses of frames relative to each other.

    The transform nearest to the requested time is used, without interpolation, since scans are taken while
    the camera stands still.

    Parameters
    ----------
    age
        Largest difference between the requested time and that of a transform, seconds. Static transforms are
        valid at any time.

    Examples
    --------
    >>> frames = Frames()
    >>> frames.add("world", "camera", 5.0, [0.0, 0.0, 0.7], [1.0, 0.0, 0.0, 0.0])
    >>> frames.pose("world", "camera", 5.1)
    array([[ 1. ,  0. ,  0. ,  0. ],
           [ 0. , -1. ,  0. ,  0. ],
           [ 0. ,  0. , -1. ,  0.7],
           [ 0. ,  0. ,  0. ,  1. ]])
    """

    def __init__(self, age: float = 0.2) -> None:
        self._age = age
        self._parents: dict[str, str] = {}
        self._static: dict[str, Pose] = {}
        self._moving: dict[str, deque[tuple[float, Pose]]] = {}

    def add(
        self,
        parent: str,
        child: str,
        stamp: float | None,
        translation: Sequence[float],
        quaternion: Sequence[float],
    ) -> None:
        """Add a transform from `child` to `parent` coordinates.

        Parameters
        ----------
        parent, child
            Names of frames.
        stamp
            Time, seconds; None for a static transform.
        translation
            Origin of `child` in `parent`, metres.
        quaternion
            Orientation (x, y, z, w).

        Raises
        ------
        CellError
            If it is not a rigid transform.
        """
        parent, child = parent.lstrip("/"), child.lstrip("/")
        pose = rigid(translation, quaternion)
        self._parents[child] = parent
        if stamp is None:
            self._static[child] = pose
            return
        history = self._moving.setdefault(child, deque())
        history.append((stamp, pose))
        while history[0][0] < stamp - HISTORY:
            history.popleft()

    def pose(self, world: str, camera: str, stamp: float) -> Pose:
        """Return `world_from_camera` at a time, shape (4, 4).

        Raises
        ------
        CellError
            If the frames are not connected at that time.
        """
        root, root_from_camera = self._to_root(camera.lstrip("/"), stamp)
        other, root_from_world = self._to_root(world.lstrip("/"), stamp)
        if root != other:
            raise CellError(
                f"no transforms lead from {camera!r} to {world!r} (they end at {root!r} and {other!r}), "
                f"expected one tree; known are {self._known()}: publish what is missing"
            )
        pose: Pose = np.linalg.inv(root_from_world) @ root_from_camera
        return pose

    def _to_root(self, frame: str, stamp: float) -> tuple[str, Pose]:
        """Return the root above `frame` and `root_from_frame`."""
        pose, seen = np.eye(4), {frame}
        while frame in self._parents:
            pose = self._at(frame, stamp) @ pose
            frame = self._parents[frame]
            if frame in seen:
                raise CellError(f"the frames {sorted(seen)} form a cycle, expected a tree; correct tf")
            seen.add(frame)
        return frame, pose

    def _at(self, child: str, stamp: float) -> Pose:
        if child in self._static:
            return self._static[child]
        nearest, pose = min(self._moving[child], key=lambda entry: abs(entry[0] - stamp))
        if abs(nearest - stamp) > self._age:
            raise CellError(
                f"the transform from {child!r} to {self._parents[child]!r} nearest to the time {stamp:.3f} "
                f"is {abs(nearest - stamp):.3f} s away, expected at most {self._age:g} s; publish more often"
            )
        return pose

    def _known(self) -> str:
        return ", ".join(f"{child} in {parent}" for child, parent in sorted(self._parents.items())) or "none"


def rigid(translation: Sequence[float], quaternion: Sequence[float]) -> Pose:
    """Return the transform of a translation and a quaternion (x, y, z, w), shape (4, 4).

    Raises
    ------
    CellError
        If they are not finite, or the quaternion's length is not 1.
    """
    length = float(np.linalg.norm(quaternion))
    if not np.isfinite(translation).all() or not abs(length - 1.0) < QUATERNION_SLACK:
        raise CellError(
            f"the translation {list(translation)} and the quaternion {list(quaternion)} of length {length:g} "
            "are not a rigid transform, expected finite numbers and length 1; check their publisher"
        )
    return from_quaternion(translation, [float(part) / length for part in quaternion])


def quaternion_of(pose: Pose) -> tuple[float, float, float, float]:
    """Return the orientation of a rigid transform as a quaternion (x, y, z, w)."""
    r = pose[:3, :3]
    trace = float(np.trace(r))
    # 4 q q^T: its longest column is q, scaled, without cancellation.
    outer = np.array(
        [
            [1.0 + 2.0 * r[0, 0] - trace, r[0, 1] + r[1, 0], r[0, 2] + r[2, 0], r[2, 1] - r[1, 2]],
            [r[0, 1] + r[1, 0], 1.0 + 2.0 * r[1, 1] - trace, r[1, 2] + r[2, 1], r[0, 2] - r[2, 0]],
            [r[0, 2] + r[2, 0], r[1, 2] + r[2, 1], 1.0 + 2.0 * r[2, 2] - trace, r[1, 0] - r[0, 1]],
            [r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1], 1.0 + trace],
        ]
    )
    longest = outer[:, int(np.argmax(np.diag(outer)))]
    x, y, z, w = (longest / np.linalg.norm(longest)).tolist()
    return x, y, z, w
