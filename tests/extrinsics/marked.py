"""Simulated scans of a belt with marks: cylinders at known places."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from beltsort.extrinsics.landmarks import Landmarks, find_landmarks
from beltsort.extrinsics.scans import MarkedScan
from beltsort.geometry import Points, Pose, inverse, look_at, on_sphere
from beltsort.sim.config import ArmErrors
from beltsort.sim.noise import noisy_depth
from beltsort.sim.scene import Scene
from beltsort.sim.sensor import Camera, SensorNoise
from beltsort.sim.surfaces import Mesh

PLACES = np.array([[0.0, 0.0], [0.36, 0.0]])
HEIGHTS = (0.12, 0.07)
RADIUS = 0.035
PRECISE = ArmErrors(position=0.0001, angle=0.01)  # an industrial arm
CAMERA = Camera()


def pose_of(rotation_vector: ArrayLike, position: ArrayLike) -> Pose:
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_rotvec(rotation_vector).as_matrix()
    pose[:3, 3] = position
    return pose


def cylinder(place: Points, height: float, radius: float = RADIUS, sides: int = 40) -> Mesh:
    angle = np.linspace(0.0, 2.0 * np.pi, sides, endpoint=False)
    circle = np.column_stack([np.cos(angle), np.sin(angle)]) * radius + place
    rings = [np.column_stack([circle, np.full(sides, z)]) for z in (0.0, height)]
    vertices = np.vstack([*rings, [[*place, height]]])
    n = np.arange(sides)
    after = (n + 1) % sides
    top = np.full(sides, 2 * sides)
    faces = [(n, after, n + sides), (after, after + sides, n + sides), (n + sides, after + sides, top)]
    return Mesh(vertices, np.vstack([np.column_stack(face) for face in faces]))


def scene(places: Points = PLACES, heights: Sequence[float] = HEIGHTS) -> Scene:
    belt = np.array([[-0.15, -0.15, 0.0], [0.6, -0.15, 0.0], [0.6, 0.15, 0.0], [-0.15, 0.15, 0.0]])
    marks = [cylinder(place, height) for place, height in zip(places, heights, strict=False)]
    return Scene(belt, marks, [], CAMERA)


def cloud(view_of: Scene, belt_from_camera: Pose, seed: int = 0) -> Points:
    """Return a scan with the noise of the simulated cell's camera, camera frame, shape (n, 3)."""
    view = view_of.view(belt_from_camera)
    depth = noisy_depth(view, SensorNoise(), CAMERA, np.random.default_rng(seed))
    points = CAMERA.deproject(depth, view.top, view.left).reshape(-1, 3)
    return points[np.isfinite(points).all(axis=1)]


MOST = 40


def poses(count: int) -> list[Pose]:
    """Return cameras around the belt, `belt_from_camera`, some turned about their optical axes.

    Their distances differ: if the camera only turned about one point, mirrored points would fit as well.
    """
    found = []
    middle = np.array([0.15, 0.0, 0.0])
    for n in range(count):
        elevation, radius = 35.0 + 40.0 * (7 * n % MOST) / MOST, 0.7 + 0.07 * (n % 4)
        pose = look_at(middle + on_sphere(137.5 * n, elevation, radius, np.zeros(3)), middle)
        found.append(pose @ pose_of([0.0, 0.0, np.radians(25.0 * (n % 3 - 1))], [0.0, 0.0, 0.0]))
    return found


@cache
def landmarks(n: int) -> Landmarks:
    return find_landmarks(cloud(scene(), poses(n + 1)[n], n), len(PLACES))


def marked_scans(
    world_from_belt: Pose, count: int, arm: ArmErrors = PRECISE, flange_from_camera: Pose | None = None
) -> list[MarkedScan]:
    """Return scans with the poses that an arm reports, of the camera or, with a hand-eye, of the flange."""
    rng = np.random.default_rng(3)
    scans = []
    for n, pose in enumerate(poses(count)):
        reported = world_from_belt @ pose @ inverse(arm.true_pose(np.eye(4), rng))
        if flange_from_camera is not None:
            reported = reported @ inverse(flange_from_camera)
        scans.append(MarkedScan(f"{n}.npy", PLACES, landmarks(n), reported))
    return scans


def one_mark(scan: MarkedScan, k: int) -> MarkedScan:
    """Return the scan as if one of its marks stood alone."""
    alone = replace(scan.landmarks, marks=scan.landmarks.marks[[k]])
    return replace(scan, places=scan.places[[k]], landmarks=alone)
