"""Objects in their cups: size, pose, and where they come to rest."""

from itertools import product

import numpy as np

from beltsort.geometry import BeltLayout, Points, Pose
from beltsort.sim.config import CellConfig, Cup, PoseMix
from beltsort.sim.rotations import rotation
from beltsort.sim.surfaces import Mesh, Profile, revolve

REACH = 0.016  # metres; how far from the cup's axis an object's middle may settle
OFFSETS = 9  # places tried along each axis


def cup_mesh(cup: Cup, layout: BeltLayout) -> Mesh:
    """Return a cup standing on the belt at the origin."""
    return revolve(_cup_outline(cup, layout))


def _cup_outline(cup: Cup, layout: BeltLayout) -> Profile:
    rim, height = layout.rim_radius, layout.rim_height
    return np.array([
        (0.0, 0.0), (cup.floor_radius + cup.wall, 0.0), (rim, height), (rim - cup.wall, height),
        (cup.floor_radius, cup.floor_height), (0.0, cup.floor_height),
    ])  # fmt: skip


def draw_object(nominal: Mesh, config: CellConfig, rng: np.random.Generator) -> Mesh:
    """Draw an object's size and pose and return its mesh at rest in a cup at the origin."""
    radial, axial = np.exp(rng.normal(0.0, config.size_spread, 2))
    turned = nominal.scaled(radial, axial).moved(_orientation(config.poses, rng))
    return at_rest(turned, config.cup, config.layout)


def _orientation(poses: PoseMix, rng: np.random.Generator) -> Pose:
    """Draw spin about the object's axis, tilt of that axis, and yaw about the vertical, shape (4, 4)."""
    frequencies = np.array([poses.upright, poses.leaning, poses.lying])
    ranges = (poses.upright_tilt, poses.leaning_tilt, poses.lying_tilt)
    tilt = np.radians(rng.uniform(*ranges[rng.choice(3, p=frequencies / frequencies.sum())]))
    spin, yaw = rng.uniform(0.0, 2.0 * np.pi, 2)
    turn = rotation([0.0, 0.0, yaw]) @ rotation([0.0, tilt, 0.0]) @ rotation([0.0, 0.0, spin])
    pose = np.eye(4)
    pose[:3, :3] = turn
    return pose


def at_rest(turned: Mesh, cup: Cup, layout: BeltLayout) -> Mesh:
    """Lower a mesh of given orientation into the cup where it sinks deepest, and return it there.

    The mesh is lowered straight down at each of a grid of places about the cup's axis until it touches; of
    these places the one with the lowest potential energy wins.
    """
    low, high = turned.vertices.min(axis=0), turned.vertices.max(axis=0)
    vertices = turned.vertices - (low + high) / 2.0
    steps = np.linspace(-REACH, REACH, OFFSETS)
    heights = {
        (dx, dy): _touching_height(vertices + np.array([dx, dy, 0.0]), cup, layout)
        for dx, dy in product(steps, steps)
    }
    dx, dy = min(heights, key=lambda place: heights[place])
    return Mesh(vertices + np.array([dx, dy, heights[dx, dy]]), turned.triangles)


def _touching_height(vertices: Points, cup: Cup, layout: BeltLayout) -> float:
    """Return how far up `vertices` must move so that none lies inside the cup or the belt."""
    rho = np.hypot(vertices[:, 0], vertices[:, 1])
    solid = np.interp(
        rho, [cup.floor_radius, layout.rim_radius - cup.wall], [cup.floor_height, layout.rim_height]
    )
    solid = np.where(rho <= layout.rim_radius, solid, 0.0)
    return float((solid - vertices[:, 2]).max())
