"""Clouds as they should not be: few, alike, in line, not finite, far too many, in another unit."""

import tracemalloc
import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from beltsort import _core
from beltsort.errors import CloudError
from beltsort.geometry import BeltLayout, Points
from beltsort.perception import Finding, UnitWarning, describe, oriented_normals, segment
from tests.laws import cases
from tests.perception.belt_scene import Scene, SyntheticScan

LAYOUT = BeltLayout()
CAMERA = np.array([0.0, 0.3, 0.6])
ROUND = (0.03, 0.03, 0.03)

DEGENERATE: dict[str, Points] = {
    "collinear": np.outer(np.linspace(0.0, 0.1, 50), [1.0, 1.0, 0.5]),
    "towards the camera": np.outer(np.linspace(0.0, 0.5, 50), CAMERA),
    "all the same": np.tile([[0.02, 0.03, 0.08]], (50, 1)),
    "pairs of duplicates": np.repeat(np.random.default_rng(0).normal(scale=0.03, size=(30, 3)), 2, axis=0),
    "seven": np.random.default_rng(1).normal(scale=0.03, size=(7, 3)),
    "three": np.eye(3) * 0.05,
}


@pytest.fixture
def scene() -> Scene:
    return Scene(LAYOUT, np.random.default_rng(7))


@pytest.mark.parametrize("name", DEGENERATE)
def test_degenerate_clouds_have_a_descriptor(name: str) -> None:
    cloud = DEGENERATE[name]
    normals = oriented_normals(cloud, CAMERA, 20)
    assert np.allclose(np.linalg.norm(normals, axis=1), 1.0)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UnitWarning)  # points that are all the same have no extent
        histogram = describe(cloud, CAMERA)
    assert np.isfinite(histogram).all()
    assert histogram[180:].sum() == pytest.approx(100.0)


@pytest.mark.parametrize("n", [1, 2])
def test_one_and_two_points_have_none(n: int) -> None:
    with pytest.raises(CloudError, match=rf"\b{n} points\b.*\b3\b"):
        describe(DEGENERATE["three"][:n], CAMERA)


@pytest.mark.parametrize("n", [1, 2, 7])
def test_scans_of_a_few_points_show_nothing(scene: Scene, n: int) -> None:
    scan = scene.scan(scene.belt())
    few = SyntheticScan(scan.points[1 : n + 1], scan.world_from_camera)
    assert segment(few, LAYOUT).findings == (Finding.HIDDEN, Finding.HIDDEN)


@pytest.mark.parametrize("name", DEGENERATE)
def test_degenerate_objects_are_segmented(scene: Scene, name: str) -> None:
    centred = DEGENERATE[name] - DEGENERATE[name].mean(axis=0) + [0.0, 0.0, 0.1]
    scan = scene.scan(scene.belt(), centred)
    assert segment(scan, LAYOUT).findings[1] is Finding.EMPTY


@cases(100)
@given(
    points=arrays.arrays(
        np.float64, st.tuples(st.integers(1, 40), st.just(3)), elements=st.floats(width=64, allow_nan=True)
    )
)
def test_any_numbers_are_a_scan_or_a_cloud_error(points: Points) -> None:
    scan = SyntheticScan(points, np.eye(4))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            segmented = segment(scan, LAYOUT)
        except CloudError:
            return
    assert len(segmented.findings) == LAYOUT.positions


@pytest.mark.slow
def test_ten_million_points_take_bounded_memory(scene: Scene) -> None:
    scan = scene.scan(scene.ellipsoid(0, ROUND))
    many = SyntheticScan(np.resize(scan.points, (10_000_000, 3)), scan.world_from_camera)
    tracemalloc.start()
    try:
        assert segment(many, LAYOUT).findings[0] is Finding.OBJECT
        assert tracemalloc.get_traced_memory()[1] < 400e6
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("factor", [1000.0, 0.001])
def test_a_scan_in_another_unit_is_told(scene: Scene, factor: float) -> None:
    scan = scene.scan(scene.belt(), scene.ellipsoid(0, ROUND))
    with pytest.warns(UnitWarning, match=rf"lengths \* {1 / factor:g}"):
        segment(SyntheticScan(scan.points * factor, scan.world_from_camera), LAYOUT)


def test_a_pose_in_millimetres_is_told(scene: Scene) -> None:
    scan = scene.scan(scene.belt())
    pose = scan.world_from_camera.copy()
    pose[:3, 3] *= 1000.0
    with pytest.warns(UnitWarning, match=r"camera\b.*distance\b.*\b700\b.*\* 0\.001\b"):
        segment(SyntheticScan(scan.points, pose), LAYOUT)


def test_an_object_in_another_unit_is_told(scene: Scene) -> None:
    points = scene.ellipsoid(0, ROUND)
    with pytest.warns(UnitWarning, match=r"extent\b.*\b60\b.*\b0\.001\b.*\b5\b.*\* 0\.001\b"):
        describe(1000.0 * points, 1000.0 * CAMERA)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        describe(points, CAMERA)
        segment(scene.scan(scene.belt(), points), LAYOUT)


@cases(50)
@given(seed=st.integers(0, 10_000), gap=st.floats(0.05, 0.5))
def test_clusters_lie_apart_and_do_not_depend_on_order(seed: int, gap: float) -> None:
    rng = np.random.default_rng(seed)
    points = rng.uniform(size=(80, 3))
    cluster = _core.clusters(points, gap)
    distance = np.linalg.norm(points[:, None] - points, axis=-1)
    assert (distance[cluster[:, None] != cluster] > gap).all()
    order = rng.permutation(80)
    again = _core.clusters(points[order], gap)
    same = cluster[:, None] == cluster
    assert np.array_equal(again[:, None] == again, same[np.ix_(order, order)])
