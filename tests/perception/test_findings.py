"""Every position gets a named finding: what was found, or why nothing was."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from beltsort.geometry import BeltLayout, look_at
from beltsort.perception import Finding, PerceptionConfig, segment
from beltsort.perception.visibility import crossings, image_border, share_seen, within_gap
from beltsort.sim import ArmErrors, CellConfig, SensorNoise, SimulatedCell
from tests.laws import cases
from tests.perception.belt_scene import Scene, SyntheticScan

LAYOUT = BeltLayout()
ROUND = (0.03, 0.03, 0.03)


@pytest.fixture
def scene() -> Scene:
    return Scene(LAYOUT, np.random.default_rng(7))


def findings(scan: SyntheticScan, config: PerceptionConfig | None = None) -> tuple[Finding, ...]:
    return segment(scan, LAYOUT, config).findings


def image_of(label: int | None, columns: slice = slice(None), loss: float = 0.0) -> SyntheticScan:
    """Return some columns of the simulated cell's image, in which glass loses this share of its returns."""
    sensor = SensorNoise(gloss_loss=loss, gloss_loss_grazing=loss, highlight=0.0)
    config = CellConfig(noise=sensor, arm=ArmErrors(position=0.0, angle=0.0))
    cell = SimulatedCell([label], config, seed=3)
    scan = cell.scan(not_before=cell.move_to(1, "move"))
    return SyntheticScan(scan.points[:, columns], scan.world_from_camera)


def test_an_object_and_an_empty_cup(scene: Scene) -> None:
    scan = scene.scan(scene.belt(), scene.cup(0), scene.cup(1), scene.ellipsoid(0, ROUND))
    segmented = segment(scan, LAYOUT)
    assert segmented.findings == (Finding.OBJECT, Finding.EMPTY)
    assert segmented.objects[0] is segmented.candidates[0]
    assert segmented.objects[1] is None


def test_glass_without_returns_is_hidden_not_empty() -> None:
    for label in (1, 2, 3):  # the first class is slim enough to leave most of the opening in sight
        assert findings(image_of(label, loss=1.0))[0] is Finding.HIDDEN
    assert findings(image_of(None, loss=1.0))[0] is Finding.EMPTY


def test_no_data_about_a_position_is_hidden(scene: Scene) -> None:
    scan = scene.scan(scene.belt() - [0.35, 0.0, 0.0])
    assert findings(scan) == (Finding.EMPTY, Finding.HIDDEN)


def test_a_camera_below_the_rims_sees_no_cup_empty(scene: Scene) -> None:
    low = look_at(np.array([0.0, 0.6, 0.03]), np.array([0.0, 0.0, 0.03]))
    points = (scene.cup(0) - low[:3, 3]) @ low[:3, :3]
    assert findings(SyntheticScan(points, low))[0] is Finding.HIDDEN


def test_two_objects_in_one_cup(scene: Scene) -> None:
    aside = [0.035, 0.0, 0.0]
    small = (0.01, 0.012, 0.04)
    pair = [scene.ellipsoid(0, small) + aside, scene.ellipsoid(0, small) - aside]
    segmented = segment(scene.scan(scene.belt(), *pair), LAYOUT)
    assert segmented.findings[0] is Finding.SEVERAL
    assert segmented.candidates[0] is not None
    assert segmented.objects[0] is None
    assert findings(scene.scan(scene.belt(), pair[0]))[0] is Finding.OBJECT


def test_pieces_of_one_object_are_not_several(scene: Scene) -> None:
    whole = scene.ellipsoid(0, ROUND, 8000)
    scan = scene.scan(scene.belt(), whole[np.abs(whole[:, 2] - 0.08) > 0.01])
    assert findings(scan)[0] is Finding.OBJECT


def test_too_few_points(scene: Scene) -> None:
    tip = scene.ellipsoid(0, ROUND)
    tip = tip[tip[:, 2] > 0.0975]
    assert findings(scene.scan(scene.belt(), tip))[0] is Finding.TOO_FEW


def test_an_object_at_the_edge_of_the_image_is_cut_off() -> None:
    assert findings(image_of(0))[0] is Finding.OBJECT
    assert findings(image_of(0, slice(320, None)))[0] is Finding.CUT
    assert findings(image_of(0, slice(None, 320)))[0] is Finding.CUT
    assert findings(image_of(0, slice(370, None)))[0] is Finding.HIDDEN
    assert findings(image_of(None, slice(240, None)))[0] is Finding.EMPTY


def test_a_list_of_points_has_no_edge() -> None:
    half = image_of(0, slice(320, None))
    for shape in ((-1, 3), (1, -1, 3), (-1, 1, 3)):
        listed = SyntheticScan(half.points.reshape(shape), half.world_from_camera)
        assert findings(listed)[0] is Finding.OBJECT


def test_candidates_belong_to_positions_by_place_not_by_size(scene: Scene) -> None:
    large, small = (
        scene.ellipsoid(1, (0.05, 0.05, 0.07), 20_000),
        scene.ellipsoid(0, (0.015, 0.015, 0.03), 800),
    )
    first, second = segment(scene.scan(scene.belt(), large, small), LAYOUT).candidates
    assert first is not None
    assert second is not None
    assert len(first) < len(second)
    assert abs(first[:, 0].mean()) < 0.01


@cases(50)
@given(radius=st.floats(0.01, 0.1), x=st.floats(-1.0, 1.0), covered=st.floats(-1.0, 1.0))
def test_the_share_seen_of_a_disc(radius: float, x: float, covered: float) -> None:
    across = np.linspace(-1.2, 1.2, 97) * radius
    grid = np.stack(np.meshgrid(across + x, across), axis=-1).reshape(-1, 2)
    centre = np.array([x, 0.0])
    assert share_seen(grid, centre, radius) == 1.0
    assert share_seen(grid[:0], centre, radius) == 0.0
    half = share_seen(grid[grid[:, 1] < covered * radius], centre, radius)
    assert 0.0 <= half <= 1.0
    assert half >= share_seen(grid[grid[:, 1] < 0.5 * covered * radius - 0.5 * radius], centre, radius)


def test_lines_of_sight_pass_the_level_where_they_should() -> None:
    pose = look_at(np.array([0.0, 0.0, 1.0]), np.zeros(3))
    world = np.array([[0.4, 0.2, 0.0], [0.0, 0.0, 0.6], [0.1, 0.0, np.nan]])
    points = (world - pose[:3, 3]) @ pose[:3, :3]
    assert np.allclose(crossings(points, world[:, 2], pose, 0.5), [[0.2, 0.1]])


def test_the_border_of_an_image_and_what_within_gapes() -> None:
    image = np.arange(7 * 9 * 3, dtype=float).reshape(7, 9, 3)
    border = {tuple(point) for point in image_border(image)}
    assert border == {tuple(point) for point in image.reshape(-1, 3)} - {
        tuple(point) for point in image[2:-2, 2:-2].reshape(-1, 3)
    }
    assert image_border(image[:4]).shape == image_border(image.reshape(-1, 3)).shape == (0, 3)
    assert within_gap(np.zeros((1, 3)), np.full((2, 3), 0.5), 0.9)
    assert not within_gap(np.zeros((1, 3)), np.full((2, 3), 0.5), 0.8)
    assert not within_gap(np.zeros((0, 3)), np.zeros((2, 3)), 1.0)


def test_more_positions_more_outcomes(scene: Scene) -> None:
    scan = scene.scan(scene.belt(), scene.ellipsoid(2, ROUND))
    found = segment(scan, replace(LAYOUT, positions=3)).findings
    assert found == (Finding.EMPTY, Finding.EMPTY, Finding.OBJECT)
