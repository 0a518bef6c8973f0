"""Frames and the layout of the belt.

World frame (also called belt frame): origin on the belt surface under the belt end (position index 0), x
along the belt *upstream*, z up, metres. Camera frame: the optical frame, x right, y down, z forward. A pose
`world_from_camera` maps camera coordinates to world coordinates.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]
"""Points, shape (..., 3), metres; NaN where a pixel has no return."""

Pose = NDArray[np.float64]
"""A rigid transform, shape (4, 4)."""


@dataclass(frozen=True)
class BeltLayout:
    """Layout of the belt: `positions` cups, `spacing` metres apart, the belt end first.

    Attributes
    ----------
    positions
        H, the number of belt positions seen at once.
    spacing
        Distance between neighbouring positions, metres.
    rim_height, rim_radius
        Height of a cup's rim above the belt and its radius, metres. Points above the rim are the object's.
    crop_height, crop_radius
        Upper end and radius of the upright cylinder around a position to which its object is cropped, metres.
    """

    positions: int = 2
    spacing: float = 0.18
    rim_height: float = 0.05
    rim_radius: float = 0.04
    crop_height: float = 0.25
    crop_radius: float = 0.085

    def centre(self, position: int) -> Points:
        """Return the point of the belt surface under `position`, shape (3,), world frame."""
        return np.array([position * self.spacing, 0.0, 0.0])

    @property
    def extent(self) -> tuple[float, float]:
        """Smallest and largest x of the positions, metres; zeros if there are none."""
        along = [float(self.centre(position)[0]) for position in range(self.positions)]
        return min(along, default=0.0), max(along, default=0.0)

    def at(self, places: Iterable[float]) -> "PlacedLayout":
        """Return a layout with the same cups at other places.

        Parameters
        ----------
        places
            The x of each position, metres, in any order.

        Examples
        --------
        >>> BeltLayout().at([0.03, 0.21]).centre(1).tolist()
        [0.21, 0.0, 0.0]
        """
        along = tuple(map(float, places))
        sizes = self.rim_height, self.rim_radius, self.crop_height, self.crop_radius
        return PlacedLayout(len(along), self.spacing, *sizes, along)


@dataclass(frozen=True)
class PlacedLayout(BeltLayout):
    """A layout whose positions are anywhere along the belt; made by `BeltLayout.at`.

    Attributes
    ----------
    places
        The x of each position, metres; as many as `positions`.
    """

    places: tuple[float, ...] = ()

    def centre(self, position: int) -> Points:
        """Return the point of the belt surface under `position`, shape (3,), world frame."""
        return np.array([self.places[position], 0.0, 0.0])


def on_sphere(azimuth: float, elevation: float, radius: float, centre: Points) -> Points:
    """Return the point at `azimuth`, `elevation` (degrees), `radius` (metres) from `centre`, shape (3,)."""
    a, e = np.radians(azimuth), np.radians(elevation)
    return centre + radius * np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])


def direction_of(points: Points) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return azimuth and elevation (degrees) of points as seen from the origin, shape (...,) each."""
    x, y, z = np.moveaxis(points, -1, 0)
    return np.degrees(np.arctan2(y, x)), np.degrees(np.arctan2(z, np.hypot(x, y)))


def look_at(eye: Points, target: Points) -> Pose:
    """Return `world_from_camera` of a camera at `eye` that looks at `target`, with world z up in the image.

    If the camera looks along world z, where this is undefined, world x is up in the image.
    """
    forward = (target - eye) / np.linalg.norm(target - eye)
    up = np.array([1.0, 0.0, 0.0]) if abs(forward[2]) > 1.0 - 1e-9 else np.array([0.0, 0.0, 1.0])
    right = np.cross(forward, up)
    right /= np.linalg.norm(right)
    pose = np.eye(4)
    pose[:3, :3] = np.column_stack([right, np.cross(forward, right), forward])
    pose[:3, 3] = eye
    return pose


@dataclass(frozen=True)
class SphereViewpoint:
    """A viewpoint on the half-sphere around the belt end.

    Attributes
    ----------
    azimuth, elevation
        Direction from the belt end to the camera, degrees: azimuth 0 is upstream, 180 beyond the belt end,
        elevation 90 straight above.
    radius
        Distance of the camera from the belt end, metres.
    """

    name: str
    azimuth: float
    elevation: float
    radius: float = 0.7

    def pose(self) -> Pose:
        """Return `world_from_camera` of a camera at this viewpoint that looks at the belt end."""
        belt_end = np.zeros(3)
        return look_at(on_sphere(self.azimuth, self.elevation, self.radius, belt_end), belt_end)


def inverse(pose: Pose) -> Pose:
    """Return the inverse of a rigid transform, shape (4, 4)."""
    inverted = np.eye(4)
    inverted[:3, :3] = pose[:3, :3].T
    inverted[:3, 3] = -pose[:3, :3].T @ pose[:3, 3]
    return inverted


def transform(pose: Pose, points: Points) -> Points:
    """Apply a rigid transform, shape (4, 4), to points of shape (..., 3)."""
    return points @ pose[:3, :3].T + pose[:3, 3]
