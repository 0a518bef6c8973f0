import numpy as np
import pytest

from beltsort.geometry import Points, look_at, transform
from beltsort.sim import Camera
from beltsort.sim.scene import Scene
from beltsort.sim.surfaces import Mesh, revolve

BELT = np.array([[-0.3, -0.3, 0.0], [0.3, -0.3, 0.0], [0.3, 0.3, 0.0], [-0.3, 0.3, 0.0]])
CAMERA = Camera()


def box(half: float, height: float) -> Mesh:
    return revolve(np.array([[0.0, 0.0], [half, 0.0], [half, height], [0.0, height]]))


def world_points(scene: Scene, eye: Points) -> tuple[Points, np.ndarray]:
    """Return the points that a perfect camera at `eye` sees, world frame, and whether they are glass."""
    pose = look_at(eye, np.zeros(3))
    view = scene.view(pose)
    return transform(pose, CAMERA.deproject(view.depth, view.top, view.left)), view.glass


@pytest.mark.parametrize("eye", [(0.3, 0.5, 0.4), (-0.5, 0.0, 0.5), (0.0, 0.0, 0.7)])
def test_an_empty_belt_is_seen_where_it_is(eye: tuple[float, float, float]) -> None:
    points, glass = world_points(Scene(BELT, [], [], CAMERA), np.array(eye))
    points = points[np.isfinite(points[..., 2])]
    assert len(points) > 50_000
    assert np.abs(points[:, 2]).max() < 1e-5
    assert np.abs(points[:, :2]).max() < 0.3 + 1e-5
    assert not glass.any()


def test_the_top_of_a_cylinder_is_seen_at_its_height_and_is_glass() -> None:
    points, glass = world_points(Scene(BELT, [], [box(0.03, 0.1)], CAMERA), np.array([0.0, 0.3, 0.6]))
    on_top = np.abs(points[..., 2] - 0.1) < 1e-5
    assert on_top.sum() > 1000
    assert np.hypot(points[on_top, 0], points[on_top, 1]).max() < 0.03 + 1e-5
    assert glass[on_top].all()
    assert not glass[np.abs(points[..., 2]) < 1e-5].any()


def test_a_cup_hides_what_stands_behind_it_and_is_matt() -> None:
    behind = box(0.02, 0.05).moved(look_at_nothing(x=-0.1))
    points, glass = world_points(Scene(BELT, [box(0.05, 0.15)], [behind], CAMERA), np.array([0.6, 0.0, 0.1]))
    assert not glass.any()
    assert (points[..., 2] > 0.05).sum() > 1000


def look_at_nothing(x: float) -> Points:
    pose = np.eye(4)
    pose[0, 3] = x
    return pose


def test_incidence_is_the_angle_to_the_normal() -> None:
    pose = look_at(np.array([0.0, 0.4, 0.4]), np.zeros(3))
    view = Scene(BELT, [], [], CAMERA).view(pose)
    middle = (240 - view.top, 320 - view.left)
    assert view.incidence[middle] == pytest.approx(np.pi / 4, abs=2e-3)


def test_the_shadow_lies_on_the_side_away_from_the_projector() -> None:
    pose = look_at(np.array([0.0, 0.0, 0.7]), np.zeros(3))  # image x is world -y
    points, _ = world_points(Scene(BELT, [box(0.03, 0.1)], [], CAMERA), np.array([0.0, 0.0, 0.7]))
    view = Scene(BELT, [box(0.03, 0.1)], [], CAMERA).view(pose)
    shaded = (points[np.isfinite(view.depth) & ~view.lit] - pose[:3, 3]) @ pose[:3, :3]
    assert len(shaded) > 100
    assert shaded[:, 0].max() < 0.0  # the projector stands at positive x of the camera frame
    height, gap = 0.1, 0.7 - 0.1
    edge = 0.03 + (CAMERA.baseline + 0.03) * height / gap
    assert -shaded[:, 0].min() == pytest.approx(edge, abs=3e-3)
