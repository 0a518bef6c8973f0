"""The descriptor: PCL's own output, and the laws that it obeys."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from beltsort.errors import CloudError
from beltsort.geometry import Points
from beltsort.perception import vfh, vfh_batch
from benchmarks.machine.plain_vfh import plain_vfh
from tests.laws import cases

FIXTURES = sorted((Path(__file__).parents[1] / "fixtures" / "vfh_pcl").glob("*.npz"))
OPTION_SETS: dict[str, dict[str, bool]] = {
    "vfh_default": {"size_component": False},
    "vfh_size": {},
    "vfh_size_normdist": {"normalize_distance": True},
    "vfh_raw_counts": {"raw_counts": True},
    "vfh_size_pclnormals": {},
}
OPTIONS = ("size_component", "normalize_distance", "raw_counts", "pcl_compatible")
CAMERA = np.array([0.3, -0.2, 0.6])


def bump(seed: int, n: int = 300) -> tuple[Points, Points]:
    """Return points on the upper half of a random ellipsoid, and its exact normals."""
    rng = np.random.default_rng(seed)
    unit = rng.normal(size=(n, 3))
    unit[:, 2] = np.abs(unit[:, 2])
    unit /= np.linalg.norm(unit, axis=1, keepdims=True)
    axes = rng.uniform(0.02, 0.08, size=3)
    normals = unit / axes
    return unit * axes, normals / np.linalg.norm(normals, axis=1, keepdims=True)


def rotation(axis: Points, angle: float) -> Points:
    x, y, z = axis / np.linalg.norm(axis)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    turned: Points = np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross
    return turned


def points_moved(a: Points, b: Points, n: int) -> float:
    """Return how many points lie in other bins, counting a point once per block."""
    return float(np.abs(a - b).sum() / 2.0 / (100.0 / (n - 1)))


@cases(60)
@given(seed=st.integers(0, 10_000), n=st.integers(3, 300), chosen=st.sets(st.sampled_from(OPTIONS)))
def test_equals_the_plain_version(seed: int, n: int, chosen: set[str]) -> None:
    points, normals = bump(seed, n)
    options = {name: name in chosen for name in OPTIONS}
    compiled = vfh(points, normals, viewpoint=CAMERA, **options)
    plain = plain_vfh(points, normals, CAMERA, **options)
    # Sums in another order may move a point across the edge of a bin.
    scale = (n - 1) / 100.0 if "raw_counts" not in chosen else 1.0
    assert np.abs(compiled - plain).sum() * scale / 2.0 <= 1.0


@pytest.mark.parametrize("strange", [1e-300, 1e300])
def test_lengths_beyond_all_measure_give_a_histogram(strange: float) -> None:
    points, normals = bump(0)
    histogram = vfh(strange * points, normals, viewpoint=CAMERA)
    assert np.isfinite(histogram).all()
    assert histogram[180:].sum() == pytest.approx(100.0)


def test_other_layouts_in_memory_are_the_same_cloud() -> None:
    points, normals = bump(0)
    expected = vfh(points, normals, viewpoint=CAMERA)
    wide = np.hstack([points, normals])
    assert np.array_equal(vfh(wide[:, :3], np.asfortranarray(normals), viewpoint=CAMERA), expected)
    assert np.array_equal(vfh(points.tolist(), normals.tolist(), viewpoint=tuple(CAMERA)), expected)


def test_there_are_fixtures() -> None:
    assert len(FIXTURES) == 10


@pytest.mark.parametrize("options", OPTION_SETS)
@pytest.mark.parametrize("fixture", FIXTURES, ids=lambda path: path.stem)
def test_equals_pcl_within_three_points(fixture: Path, options: str) -> None:
    stored = np.load(fixture)
    normals = stored["pcl_normals" if options == "vfh_size_pclnormals" else "normals"]
    ours = vfh(
        stored["points"],
        normals,
        viewpoint=stored["viewpoint"],
        pcl_compatible=True,
        **OPTION_SETS[options],
    )
    increment = 1.0 if options == "vfh_raw_counts" else 100.0 / (len(normals) - 1)
    assert np.abs(ours - stored[options]).sum() / 2.0 <= 3.0 * increment


@cases(30)
@given(seed=st.integers(0, 10_000))
def test_order_of_points_does_not_matter(seed: int) -> None:
    points, normals = bump(seed)
    order = np.random.default_rng(seed + 1).permutation(len(points))
    shuffled = vfh(points[order], normals[order], viewpoint=CAMERA)
    assert points_moved(vfh(points, normals, viewpoint=CAMERA), shuffled, len(points)) <= 1.0


@cases(30)
@given(seed=st.integers(0, 10_000), angle=st.floats(-3.0, 3.0))
def test_rotation_about_the_viewing_axis_does_not_matter(seed: int, angle: float) -> None:
    points, normals = bump(seed)
    centroid = points.mean(axis=0)
    turn = rotation(CAMERA - centroid, angle)
    turned = vfh((points - centroid) @ turn.T + centroid, normals @ turn.T, viewpoint=CAMERA)
    assert points_moved(vfh(points, normals, viewpoint=CAMERA), turned, len(points)) <= 1.0


@cases(30)
@given(seed=st.integers(0, 10_000), angle=st.floats(-3.0, 3.0), step=st.floats(-2.0, 2.0))
def test_a_rigid_motion_of_everything_does_not_matter(seed: int, angle: float, step: float) -> None:
    points, normals = bump(seed)
    turn, shift = rotation(np.array([1.0, 2.0, 3.0]), angle), np.array([step, -step, 0.5])
    moved = vfh(points @ turn.T + shift, normals @ turn.T, viewpoint=turn @ CAMERA + shift)
    assert points_moved(vfh(points, normals, viewpoint=CAMERA), moved, len(points)) <= 1.0


@cases(30)
@given(seed=st.integers(0, 10_000), unit=st.sampled_from([0.001, 0.0254, 10.0, 1000.0]))
def test_unit_of_length_matters_to_pcl_only(seed: int, unit: float) -> None:
    points, normals = bump(seed)

    def histogram(scale: float, pcl: bool) -> Points:
        return vfh(
            points * scale,
            normals,
            viewpoint=CAMERA * scale,
            normalize_distance=True,
            pcl_compatible=pcl,
        )

    n = len(points)
    assert points_moved(histogram(1.0, False), histogram(unit, False), n) <= 2.0
    assert points_moved(histogram(1.0, True)[180:], histogram(unit, True)[180:], n) > 20.0
    assert points_moved(histogram(1.0, True)[135:180], histogram(unit, True)[135:180], n) > 20.0


def test_turning_the_camera_around_changes_the_viewpoint_block_only() -> None:
    points, normals = bump(3)
    front, side = vfh(points, normals, viewpoint=CAMERA), vfh(points, normals, viewpoint=(0.9, 0.0, 0.0))
    assert np.array_equal(front[:180], side[:180])
    assert points_moved(front[180:], side[180:], len(points)) > 50.0


@pytest.mark.parametrize("size", [False, True])
@pytest.mark.parametrize("raw", [False, True])
def test_block_sums(size: bool, raw: bool) -> None:
    points, normals = bump(1)
    n = len(points)
    histogram = vfh(points, normals, viewpoint=CAMERA, size_component=size, raw_counts=raw)
    per_pair = n if raw else 100.0 * n / (n - 1)
    expected = [per_pair, per_pair, per_pair, per_pair if size else 0.0, n if raw else 100.0]
    blocks = np.split(histogram, [45, 90, 135, 180])
    assert [block.sum() for block in blocks] == pytest.approx(expected)


def test_bins_of_points_at_known_distances() -> None:
    square = np.array([[x, y, 0.0] for x in (-0.1, 0.1) for y in (-0.1, 0.1)])
    histogram = vfh(square, np.tile([0.0, 0.0, 1.0], (4, 1)), viewpoint=(0.0, 0.0, 0.5), raw_counts=True)
    filled = {22: 4.0, 45 + 22: 4.0, 90 + 22: 4.0, 135 + 14: 4.0, 180 + 127: 4.0}
    assert {int(i): float(histogram[i]) for i in np.flatnonzero(histogram)} == filled


def test_a_point_at_the_centroid_counts_for_the_viewpoint_only() -> None:
    cross = np.array([[0.1, 0, 0], [-0.1, 0, 0], [0, 0.1, 0], [0, -0.1, 0], [0, 0, 0]])
    histogram = vfh(cross, np.tile([0.0, 0.0, 1.0], (5, 1)), viewpoint=(0.0, 0.0, 1.0), raw_counts=True)
    assert [block.sum() for block in np.split(histogram, [45, 90, 135, 180])] == [4, 4, 4, 4, 5]


POINTS, NORMALS = bump(0, 10)


@pytest.mark.parametrize(
    ("points", "normals", "viewpoint", "said"),
    [
        (np.empty((0, 3)), np.empty((0, 3)), CAMERA, "0 points"),
        (POINTS[:2], NORMALS[:2], CAMERA, r"\b2 points\b.*\b3\b"),
        (np.where(np.arange(10)[:, None] == 4, np.nan, POINTS), NORMALS, CAMERA, r"points\b.*\b3 values\b"),
        (
            np.where(np.arange(30).reshape(10, 3) == 4, np.inf, POINTS),
            NORMALS,
            CAMERA,
            r"points\b.*\b1 values\b",
        ),
        (POINTS, np.full((10, 3), np.nan), CAMERA, r"normals\b.*\b30 values\b"),
        (POINTS, NORMALS, (0.0, np.nan, 0.0), r"viewpoint\b.*\b1 values\b"),
        (POINTS, NORMALS[:9], CAMERA, r"normals\b.*\(9, 3\).*\(10, 3\)"),
        (POINTS[:, :2], NORMALS[:, :2], CAMERA, r"points\b.*\(10, 2\).*\(n, 3\)"),
        (POINTS, NORMALS, (0.0, 0.0), r"viewpoint\b.*\(2,\).*\(3,\)"),
        (POINTS, NORMALS, POINTS.mean(axis=0), r"viewpoint\b.*\bcentroid\b"),
        ("x", "y", CAMERA, r"points\b.*'x'.*\bnumbers\b"),
        (POINTS, "y", CAMERA, r"normals\b.*'y'.*\bnumbers\b"),
    ],
)
def test_bad_input_is_a_cloud_error(points: Any, normals: Any, viewpoint: Any, said: str) -> None:
    with pytest.raises(CloudError, match=said):
        vfh(points, normals, viewpoint=viewpoint)


def test_many_clouds_are_described_as_one_by_one() -> None:
    rng = np.random.default_rng(3)
    clouds = [rng.normal(size=(n, 3)) * 0.03 for n in (5, 50, 7)]
    normals = [cloud / np.linalg.norm(cloud, axis=1, keepdims=True) for cloud in clouds]
    eyes = [(0.0, 0.0, 1.0), (0.5, 0.0, 1.0), (0.0, 0.7, 0.1)]
    rows = vfh_batch(clouds, normals, eyes, size_component=False)
    for row, cloud, directions, eye in zip(rows, clouds, normals, eyes, strict=True):
        assert np.array_equal(row, vfh(cloud, directions, viewpoint=eye, size_component=False))
    with pytest.raises(CloudError, match=r"\b3 clouds\b.*\b2\b.*normals\b.*\b3 viewpoints\b"):
        vfh_batch(clouds, normals[:2], eyes)
    with pytest.raises(CloudError) as refused:
        vfh_batch([clouds[0], clouds[1][:2]], [normals[0], normals[1][:2]], eyes[:2])
    assert refused.value.__notes__ == ["cloud 1 of 2"]
