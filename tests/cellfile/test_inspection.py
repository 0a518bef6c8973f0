"""Where the belt is seen, and what is seen of its places."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from beltsort.cell import Scan
from beltsort.cellfile.dry_run import EmptyBeltCamera
from beltsort.cellfile.inspection import seen_belt, seen_crops
from beltsort.geometry import BeltLayout, Points, Pose, look_at, on_sphere
from beltsort.sim import CellConfig, SimulatedCell, SphereViewpoint
from beltsort.sim.rotations import rotation
from tests.laws import cases

CENTRE = np.zeros(3)
OBLIQUE = look_at(on_sphere(60.0, 50.0, 0.7, CENTRE), CENTRE)


def flat(world_from_camera: Pose = OBLIQUE, reported_error: Pose | None = None) -> Scan:
    """Return an exact scan of an empty belt, whose reported pose may be wrong."""
    scan = EmptyBeltCamera(world_from_camera).scan(not_before=0.0)
    error = np.eye(4) if reported_error is None else reported_error
    return dataclasses.replace(scan, world_from_camera=error @ world_from_camera)


def moved(tilt: tuple[float, float] = (0.0, 0.0), lift: float = 0.0) -> Pose:
    """Return a tilt about the world's x and y, degrees, then a lift, metres."""
    pose = np.eye(4)
    pose[:3, :3] = rotation(np.radians([*tilt, 0.0]))
    pose[2, 3] = lift
    return pose


def test_an_exact_cell_sees_the_belt_where_it_is() -> None:
    belt = seen_belt(flat())
    assert belt.angle == pytest.approx(0.0, abs=1e-3)
    assert belt.height == pytest.approx(0.0, abs=1e-3)
    assert belt.points > 1000


@cases(20)
@given(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.floats(-0.01, 0.01))
def test_a_wrong_pose_shows_as_tilt_and_height(about_x: float, about_y: float, lift: float) -> None:
    belt = seen_belt(flat(reported_error=moved((about_x, about_y), lift)))
    assert belt.angle == pytest.approx(np.hypot(about_x, about_y), abs=0.02)
    assert belt.height == pytest.approx(1000.0 * lift, abs=0.1)


def test_a_belt_out_of_reach_has_no_points() -> None:
    assert seen_belt(flat(reported_error=moved(lift=0.1))).points == 0


@pytest.mark.parametrize("points", [np.empty((0, 3)), np.full((4, 5, 3), np.nan)])
def test_a_scan_without_points_shows_nothing(points: Points) -> None:
    scan = Scan(points, OBLIQUE, stamp=0.0)
    assert seen_belt(scan).points == 0
    crops = seen_crops(scan, BeltLayout())
    assert [(crop.inside, crop.points) for crop in crops] == [(None, 0)] * 2


def test_a_cloud_without_pixels_has_no_image_edges() -> None:
    image = flat()
    cloud = dataclasses.replace(image, points=image.points.reshape(-1, 3))
    assert seen_crops(cloud, BeltLayout())[0].inside is None
    assert seen_belt(cloud).points == seen_belt(image).points


def test_crops_leave_the_image_when_the_camera_comes_near() -> None:
    low = BeltLayout(crop_height=0.1)
    far, near = (look_at(np.array([0.0, 0.0, height]), CENTRE) for height in (1.0, 0.25))
    assert [crop.inside for crop in seen_crops(flat(far), low)] == [1.0, 1.0]
    inside = [crop.inside for crop in seen_crops(flat(near), low)]
    assert inside[1] == 0.0
    assert inside[0] is not None
    assert 0.0 < inside[0] < 1.0


def test_the_edges_of_the_image_are_where_its_camera_has_them(perfect: CellConfig) -> None:
    """The share inside, from the camera's true intrinsics."""
    cell = SimulatedCell([0, 1], perfect)
    camera, layout = perfect.camera, cell.layout
    scan = cell.scan(not_before=cell.move_to(1, "move"))
    angle = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    circle = layout.crop_radius * np.column_stack([np.cos(angle), np.sin(angle), np.zeros(24)])
    heights = np.repeat([layout.rim_height, layout.crop_height], 24)[:, None] * [0.0, 0.0, 1.0]
    world = np.vstack([circle, circle]) + heights + layout.centre(1)
    x, y, z = ((world - scan.world_from_camera[:3, 3]) @ scan.world_from_camera[:3, :3]).T
    u = x / z * camera.focal + (camera.width - 1) / 2.0
    v = y / z * camera.focal + (camera.height - 1) / 2.0
    expected = ((u > -0.5) & (u < camera.width - 0.5) & (v > -0.5) & (v < camera.height - 0.5)).mean()
    assert 0.0 < expected < 1.0
    assert seen_crops(scan, layout)[1].inside == pytest.approx(expected, abs=0.021)


def test_points_are_counted_where_objects_stand() -> None:
    """A bulb shows more of itself than of the cup that it hides."""
    overhead = CellConfig(viewpoints=(SphereViewpoint("top", 0.0, 90.0),), upstream=0)
    layout, lone = overhead.layout, BeltLayout(positions=1)
    seen = [seen_crops(SimulatedCell(labels, overhead).scan(not_before=0.0), layout) for labels in ([], [0])]
    (empty_end, empty_next), (full_end, full_next) = seen
    assert abs(full_end.points - empty_end.points) > 100
    assert full_next.points == pytest.approx(empty_next.points, abs=100)
    assert len(seen_crops(flat(), lone)) == 1
