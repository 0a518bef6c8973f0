"""A belt scene made of points: exact surfaces, chosen noise, no renderer."""

from dataclasses import dataclass

import numpy as np

from beltsort.geometry import BeltLayout, Points, Pose, look_at, on_sphere


@dataclass(frozen=True)
class SyntheticScan:
    """Points in the camera frame, shape (n, 3), and the reported pose."""

    points: Points
    world_from_camera: Pose


@dataclass(frozen=True)
class Scene:
    """Belt, cups at every position, and upright ellipsoids in some of them."""

    layout: BeltLayout
    rng: np.random.Generator
    noise: float = 0.0005

    def belt(self, n: int = 20_000) -> Points:
        return np.column_stack([self.rng.uniform([-0.25, -0.15], [0.45, 0.15], (n, 2)), np.zeros(n)])

    def cup(self, position: int, n: int = 3000) -> Points:
        angle, share = self.rng.uniform(0.0, 2.0 * np.pi, n), self.rng.uniform(0.0, 1.0, n)
        radius = 0.022 + share * (self.layout.rim_radius - 0.022)
        height = share * self.layout.rim_height
        wall = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), height])
        return wall + self.layout.centre(position)

    def ellipsoid(self, position: int, semi_axes: tuple[float, float, float], n: int = 4000) -> Points:
        unit = self.rng.normal(size=(n, 3))
        unit /= np.linalg.norm(unit, axis=1, keepdims=True)
        return unit * semi_axes + self.layout.centre(position) + [0.0, 0.0, 0.07]

    def scan(self, *parts: Points, reported_error: Pose | None = None) -> SyntheticScan:
        """Return the parts as the camera sees them; every tenth point has no return."""
        pose = look_at(on_sphere(60.0, 50.0, 0.7, np.zeros(3)), np.zeros(3))
        world: Points = np.vstack(parts)
        world += self.rng.normal(scale=self.noise, size=world.shape)
        points = (world - pose[:3, 3]) @ pose[:3, :3]
        points[::10] = np.nan
        return SyntheticScan(points, pose if reported_error is None else reported_error @ pose)
