"""Parts of hollow objects belong together, objects that stand close do not."""

from collections.abc import Sequence

import numpy as np
import pytest
from scipy.ndimage import binary_dilation

from beltsort.geometry import BeltLayout, Points, look_at, on_sphere
from beltsort.perception import Finding, segment
from beltsort.perception.parts import Background, Part
from beltsort.sim import CellConfig
from beltsort.sim.objects import cup_mesh
from beltsort.sim.scene import Scene
from beltsort.sim.surfaces import Mesh, refine, revolve
from tests.perception.belt_scene import SyntheticScan

CELL = CellConfig()
LAYOUT = BeltLayout()
BELT = np.array([[-0.1, -0.1, 0.0], [0.3, -0.1, 0.0], [0.3, 0.1, 0.0], [-0.1, 0.1, 0.0]])
ABOVE_RIM = 0.046
STEP = 0.006  # metres per pixel, of an edge in depth
AZIMUTHS = (0.0, 70.0, 200.0)


def sphere(radius: float) -> Mesh:
    angle = np.linspace(0.0, np.pi, 25)[1:-1]
    ring = radius * np.column_stack([np.sin(angle), 1.0 - np.cos(angle)])
    return revolve(np.vstack([[0.0, 0.0], ring, [0.0, 2.0 * radius]]))


def bowl(radius: float, depth: float, wall: float = 0.003) -> Mesh:
    angle = np.linspace(0.0, np.pi / 2.0, 16)[1:]
    across, up = np.sin(angle), 1.0 - np.cos(angle)
    outer = np.column_stack([radius * across, depth * up])
    inner = np.column_stack([(radius - wall) * across, wall + (depth - wall) * up])[::-1]
    return revolve(refine(np.vstack([[0.0, 0.0], outer, inner, [0.0, wall]]), 0.004))


def mug(radius: float, height: float, wall: float = 0.003) -> Mesh:
    inner = radius - wall
    outline = [(0.0, 0.0), (radius, 0.0), (radius, height), (inner, height), (inner, wall), (0.0, wall)]
    return revolve(refine(np.array(outline), 0.004))


HOLLOW = {"bowl": bowl(0.065, 0.05), "low bowl": bowl(0.05, 0.035), "mug": mug(0.045, 0.07)}


def beside(mesh: Mesh, along: float, azimuth: float = 90.0) -> Mesh:
    """Return a mesh above the first cup's rim, moved from its centre in a direction, degrees."""
    x, y = along * np.cos(np.radians(azimuth)), along * np.sin(np.radians(azimuth))
    return Mesh(mesh.vertices + np.array([x, y, ABOVE_RIM]), mesh.triangles)


def scan(meshes: Sequence[Mesh], azimuth: float, elevation: float = 45.0, lost: int = 0) -> SyntheticScan:
    """Return an exact scan, without the pixels that are less than `lost` from an edge in depth."""
    pose = look_at(on_sphere(azimuth, elevation, 0.7, np.zeros(3)), np.zeros(3))
    view = Scene(BELT, [cup_mesh(CELL.cup, LAYOUT), *meshes], [], CELL.camera).view(pose)
    depth = view.depth
    if lost:
        steps = np.gradient(np.nan_to_num(depth, nan=9.0))
        edges = np.hypot(*steps) > STEP
        depth = np.where(binary_dilation(edges, iterations=lost), np.nan, depth)
    image = np.full((CELL.camera.height, CELL.camera.width, 3), np.nan)
    (height, width), camera = depth.shape, CELL.camera
    window = image[view.top : view.top + height, view.left : view.left + width]
    window[...] = camera.deproject(depth, view.top, view.left)
    return SyntheticScan(image, pose)


def found(meshes: Sequence[Mesh], azimuth: float, elevation: float = 45.0, lost: int = 0) -> Finding:
    return segment(scan(meshes, azimuth, elevation, lost), LAYOUT).findings[0]


@pytest.mark.parametrize("azimuth", AZIMUTHS)
@pytest.mark.parametrize("lost", [0, 2, 3])
@pytest.mark.parametrize(
    "mesh", [bowl(0.065, 0.05), bowl(0.05, 0.035), mug(0.045, 0.07)], ids=["bowl", "low bowl", "mug"]
)
def test_the_walls_of_a_hollow_object_are_one_object(mesh: Mesh, lost: int, azimuth: float) -> None:
    """Their rims return nothing, as those of real ones often do, so that the walls lie apart."""
    for elevation in (30.0, 45.0):
        assert found([beside(mesh, 0.0)], azimuth, elevation, lost) is Finding.OBJECT


@pytest.mark.parametrize("azimuth", [0.0, 180.0])
@pytest.mark.parametrize("gap", [0.015, 0.02, 0.025, 0.03, 0.04])
def test_balls_beside_each_other_are_several(gap: float, azimuth: float) -> None:
    balls = [beside(sphere(0.022), side * (0.022 + gap / 2.0)) for side in (-1.0, 1.0)]
    assert found(balls, azimuth) is Finding.SEVERAL
    assert found(balls[:1], azimuth) is Finding.OBJECT


def test_a_ball_behind_a_ball_is_another_if_it_is_far_enough() -> None:
    balls = [beside(sphere(0.02), side * 0.04, azimuth=0.0) for side in (-1.0, 1.0)]
    assert found(balls, azimuth=0.0, elevation=60.0) is Finding.SEVERAL


@pytest.mark.parametrize("azimuth", AZIMUTHS)
def test_a_ball_before_or_beside_a_bowl_is_another(azimuth: float) -> None:
    pair = [beside(sphere(0.018), -0.045), beside(bowl(0.03, 0.025), 0.04)]
    assert found(pair, azimuth, elevation=55.0) is Finding.SEVERAL


def cap(radius: float, centre: Points, side: float, rng: np.random.Generator) -> tuple[Points, Points]:
    """Return points and outward normals of half a sphere, on one side along x."""
    normals = rng.normal(size=(2000, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    normals[:, 0] = side * np.abs(normals[:, 0])
    return centre + radius * normals, normals


def test_curvature_tells_inner_from_outer_walls() -> None:
    rng, centre = np.random.default_rng(0), np.array([0.1, -0.2, 0.3])
    points, normals = cap(0.05, centre, 1.0, rng)
    outer, inner = Part(points, normals), Part(points, -normals)
    assert outer.convexity == pytest.approx(-inner.convexity)
    assert outer.convexity > 0.3
    assert np.allclose(inner.centre, centre, atol=1e-9)
    opposite = Part(*cap(0.052, centre, -1.0, rng))
    assert opposite.outwards(inner.centre) == pytest.approx(1.0)
    flat = Part(points * [0.0, 1.0, 1.0], np.tile([1.0, 0.0, 0.0], (2000, 1)))
    assert flat.convexity == pytest.approx(0.0)


def test_lines_of_sight_pass_points_above_what_is_seen() -> None:
    eye = np.array([0.0, 0.0, 1.0])
    background = Background(eye, 0.1, np.array([[0.09, 0.0]]))
    points = np.array([[0.05, 0.0, 0.5], [0.05, 0.01, 0.5], [0.07, 0.0, 0.5]])
    assert background.seen_past(points).tolist() == [True, False, False]
    assert not Background(eye, 0.1, np.empty((0, 2))).seen_past(points).any()
