"""Objects in their cups: size, orientation and resting position."""

from collections.abc import Sequence
from itertools import product

import numpy as np

from beltsort.geometry import BeltLayout, Points, Pose
from beltsort.sim.config import CellConfig, Cup, PoseMix
from beltsort.sim.rotations import rotation
from beltsort.sim.surfaces import Mesh, revolve
from beltsort.util.randomness import generator

OBJECT_STREAM, SHAPE_STREAM = 0, 6  # random streams of objects and of their meshes, distinct from all others
POSES = ("upright", "leaning", "lying")

REACH = 0.016  # metres; largest distance of an object's centre from the cup's axis, along x and y
OFFSETS = 9  # candidate positions along each axis


def cup_mesh(cup: Cup, layout: BeltLayout) -> Mesh:
    """Return a cup on the belt at the origin."""
    rim, height = layout.rim_radius, layout.rim_height
    outline = np.array([
        (0.0, 0.0), (cup.floor_radius + cup.wall, 0.0), (rim, height), (rim - cup.wall, height),
        (cup.floor_radius, cup.floor_height), (0.0, cup.floor_height),
    ])  # fmt: skip
    return revolve(outline)


def object_generator(seed: int, number: int) -> np.random.Generator:
    """Return the random numbers that object `number` of a cell is drawn with."""
    return generator(seed, OBJECT_STREAM, number)


def draw_nominal(meshes: Sequence[Mesh], seed: int, number: int) -> Mesh:
    """Draw the mesh of object `number` of a cell from those of its class."""
    if len(meshes) == 1:
        return meshes[0]
    return meshes[int(generator(seed, SHAPE_STREAM, number).integers(len(meshes)))]


def draw_object(nominal: Mesh, config: CellConfig, rng: np.random.Generator) -> Mesh:
    """Draw an object's size and pose and return its mesh at rest in a cup at the origin."""
    radial, axial = np.exp(rng.normal(0.0, config.size_spread, 2))
    turned = nominal.scaled(radial, axial).moved(_orientation(config.poses, rng))
    return at_rest(turned, config.cup, config.layout)


def pose_name(config: CellConfig, rng: np.random.Generator) -> str:
    """Return how the object lies, one of `POSES`, that `draw_object` draws with the same random numbers."""
    rng.normal(0.0, config.size_spread, 2)  # its size comes first
    return POSES[_pose_of(config.poses, rng)]


def _pose_of(poses: PoseMix, rng: np.random.Generator) -> int:
    """Draw an index into `POSES`."""
    frequencies = np.array([poses.upright, poses.leaning, poses.lying])
    return int(rng.choice(len(POSES), p=frequencies / frequencies.sum()))


def _orientation(poses: PoseMix, rng: np.random.Generator) -> Pose:
    """Draw spin about the object's axis, tilt of that axis, and yaw about the vertical, shape (4, 4)."""
    ranges = (poses.upright_tilt, poses.leaning_tilt, poses.lying_tilt)
    tilt = np.radians(rng.uniform(*ranges[_pose_of(poses, rng)]))
    spin, yaw = rng.uniform(0.0, 2.0 * np.pi, 2)
    turn = rotation([0.0, 0.0, yaw]) @ rotation([0.0, tilt, 0.0]) @ rotation([0.0, 0.0, spin])
    pose = np.eye(4)
    pose[:3, :3] = turn
    return pose


def at_rest(turned: Mesh, cup: Cup, layout: BeltLayout) -> Mesh:
    """Return a mesh of given orientation at its lowest position in the cup.

    The mesh is lowered vertically at each of a grid of positions around the cup's axis until it touches the
    cup; the position with the lowest potential energy is chosen.
    """
    low, high = turned.vertices.min(axis=0), turned.vertices.max(axis=0)
    vertices = turned.vertices - (low + high) / 2.0
    steps = np.linspace(-REACH, REACH, OFFSETS)
    heights = {
        (dx, dy): _touching_height(vertices + np.array([dx, dy, 0.0]), cup, layout)
        for dx, dy in product(steps, steps)
    }
    dx, dy = min(heights, key=lambda offset: heights[offset])
    return Mesh(vertices + np.array([dx, dy, heights[dx, dy]]), turned.triangles)


def _touching_height(vertices: Points, cup: Cup, layout: BeltLayout) -> float:
    """Return the height by which `vertices` must be raised so that none is inside the cup or the belt."""
    rho = np.hypot(vertices[:, 0], vertices[:, 1])
    solid = np.interp(
        rho, [cup.floor_radius, layout.rim_radius - cup.wall], [cup.floor_height, layout.rim_height]
    )
    solid = np.where(rho <= layout.rim_radius, solid, 0.0)
    return float((solid - vertices[:, 2]).max())
