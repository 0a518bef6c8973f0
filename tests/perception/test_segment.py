"""Scan -> candidates: the right object at the right position, and nothing else."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import beltsort
from beltsort.errors import CloudError
from beltsort.geometry import BeltLayout, Points, transform
from beltsort.perception import PerceptionConfig, segment
from beltsort.perception.clean import voxel_means
from beltsort.perception.level import levelled
from tests.perception.belt_scene import Scene, SyntheticScan

LAYOUT = BeltLayout()
ROUND = (0.03, 0.03, 0.03)
TALL = (0.015, 0.02, 0.05)


@pytest.fixture
def scene() -> Scene:
    return Scene(LAYOUT, np.random.default_rng(7))


def arm_error(degrees: float, lift: float) -> Points:
    pose = np.eye(4)
    a = np.radians(degrees)
    pose[:3, :3] = [[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]]
    pose[2, 3] = lift
    return pose


def found(candidate: Points | None) -> Points:
    assert candidate is not None
    return candidate


def test_two_objects_are_two_candidates_at_their_positions(scene: Scene) -> None:
    cups = [scene.cup(j) for j in range(2)]
    scan = scene.scan(scene.belt(), *cups, scene.ellipsoid(0, ROUND), scene.ellipsoid(1, TALL))
    first, second = (found(c) for c in segment(scan, LAYOUT).candidates)
    for position, candidate, semi_axes in ((0, first, ROUND), (1, second, TALL)):
        assert candidate.mean(axis=0)[:2] == pytest.approx(LAYOUT.centre(position)[:2], abs=0.003)
        assert candidate[:, 2].min() > LAYOUT.rim_height
        assert candidate[:, 2].max() == pytest.approx(0.07 + semi_axes[2], abs=0.004)


def test_empty_cups_are_no_candidates(scene: Scene) -> None:
    scan = scene.scan(scene.belt(), scene.cup(0), scene.cup(1))
    assert segment(scan, LAYOUT).candidates == (None, None)


def test_one_empty_cup_hides_nothing(scene: Scene) -> None:
    scan = scene.scan(scene.belt(), scene.cup(0), scene.cup(1), scene.ellipsoid(1, ROUND))
    first, second = segment(scan, LAYOUT).candidates
    assert first is None
    assert found(second).mean(axis=0)[0] == pytest.approx(LAYOUT.spacing, abs=0.003)


def test_an_object_beyond_the_last_position_is_nobodys(scene: Scene) -> None:
    scan = scene.scan(scene.belt(), scene.ellipsoid(2, ROUND))
    assert segment(scan, LAYOUT).candidates == (None, None)
    assert segment(scan, replace(LAYOUT, positions=3)).candidates[2] is not None


def test_fragments_away_from_the_object_are_dropped(scene: Scene) -> None:
    strays = np.array([[0.07, 0.0, 0.2], [-0.06, 0.03, 0.15], [0.0, 0.075, 0.1]])
    fragment = np.array([0.0, -0.075, 0.2]) + scene.rng.uniform(-0.004, 0.004, (40, 3))
    scan = scene.scan(scene.belt(), scene.cup(0), scene.ellipsoid(0, ROUND), strays, fragment)
    candidate = found(segment(scan, LAYOUT).candidates[0])
    assert np.linalg.norm(candidate - [0.0, 0.0, 0.07], axis=1).max() < 0.034


def test_flying_points_beside_the_surface_are_dropped(scene: Scene) -> None:
    flying = np.array([[0.0, 0.0, 0.110], [0.04, 0.0, 0.07], [0.0, -0.04, 0.07]])
    scan = scene.scan(scene.belt(), flying, scene.ellipsoid(0, ROUND))
    candidate = found(segment(scan, LAYOUT).candidates[0])
    assert np.linalg.norm(candidate - [0.0, 0.0, 0.07], axis=1).max() < 0.034


def test_an_object_in_pieces_stays_whole(scene: Scene) -> None:
    whole = scene.ellipsoid(0, ROUND, 8000)
    pieces = whole[np.abs(whole[:, 2] - 0.08) > 0.01]
    candidate = found(segment(scene.scan(scene.belt(), pieces), LAYOUT).candidates[0])
    assert (candidate[:, 2] < 0.071).any()
    assert (candidate[:, 2] > 0.089).any()


def test_specks_do_not_add_up_to_an_object(scene: Scene) -> None:
    corners = np.array([[x, y, 0.1] for x in (-0.04, 0.0, 0.04) for y in (-0.04, 0.0, 0.04)])
    specks = np.repeat(corners, 40, axis=0) + scene.rng.uniform(-0.003, 0.003, (360, 3))
    assert segment(scene.scan(scene.belt(), specks), LAYOUT).candidates == (None, None)


@pytest.mark.parametrize(("degrees", "lift"), [(0.6, 0.009), (-0.6, 0.008), (0.0, -0.006)])
def test_an_error_of_the_arm_leaves_no_rim(scene: Scene, degrees: float, lift: float) -> None:
    parts = scene.belt(), scene.cup(0, 5000), scene.cup(1, 5000)
    scan = scene.scan(*parts, reported_error=arm_error(degrees, lift))
    assert segment(scan, LAYOUT).candidates == (None, None)
    pose = levelled(scan.points, scan.world_from_camera)
    belt = transform(pose, scan.points[: len(parts[0])])
    assert abs(np.nanmean(belt[:, 2])) < 0.0005
    assert np.nanstd(belt[:, 2]) < 1.2 * scene.noise


def test_without_belt_the_reported_pose_holds(scene: Scene) -> None:
    scan = scene.scan(scene.ellipsoid(0, ROUND))
    assert np.allclose(levelled(scan.points, scan.world_from_camera), scan.world_from_camera, atol=1e-12)


def test_levelling_is_a_rigid_motion(scene: Scene) -> None:
    scan = scene.scan(scene.belt(), reported_error=arm_error(1.0, 0.005))
    turn = levelled(scan.points, scan.world_from_camera)[:3, :3]
    assert np.allclose(turn @ turn.T, np.eye(3), atol=1e-12)


def test_the_same_scan_gives_the_same_candidates_in_any_layout(scene: Scene) -> None:
    scan = scene.scan(scene.belt(20_000), scene.cup(0), scene.ellipsoid(0, ROUND), scene.ellipsoid(1, TALL))
    image = SyntheticScan(scan.points.reshape(10, -1, 3), scan.world_from_camera)
    reference = segment(scan, LAYOUT)
    for again in (segment(scan, LAYOUT), segment(image, LAYOUT)):
        for a, b in zip(reference.candidates, again.candidates, strict=True):
            assert np.array_equal(found(a), found(b))
        assert np.array_equal(reference.camera, again.camera)


def test_infinite_points_are_ignored_like_missing_ones(scene: Scene) -> None:
    scan = scene.scan(scene.belt(), scene.cup(0), scene.ellipsoid(0, ROUND))
    infinite = np.where(np.isnan(scan.points), np.inf, scan.points)
    again = segment(SyntheticScan(infinite, scan.world_from_camera), LAYOUT)
    assert np.array_equal(found(again.candidates[0]), found(segment(scan, LAYOUT).candidates[0]))


@pytest.mark.parametrize(
    ("points", "pose", "said"),
    [
        (np.empty((0, 3)), np.eye(4), r"\b0 points\b.*\bfinite\b"),
        (np.full((4, 5, 3), np.nan), np.eye(4), r"\b20 points\b.*\bfinite\b"),
        (np.zeros((4, 5)), np.eye(4), r"points\b.*\(4, 5\).*\(n, 3\)"),
        (np.zeros((4, 3)), np.full((4, 4), np.nan), r"world_from_camera\b.*\bnan\b.*\(4, 4\)"),
        (np.zeros((4, 3)), np.eye(3), r"world_from_camera\b.*\[0\.0, 0\.0, 1\.0\]\].*\(4, 4\)"),
        ("x", np.eye(4), r"points\b.*'x'.*\bnumbers\b"),
        (np.zeros((4, 3)), "x", r"world_from_camera\b.*'x'.*\bnumbers\b"),
    ],
)
def test_no_scan_is_a_cloud_error(points: Any, pose: Any, said: str) -> None:
    with pytest.raises(CloudError, match=said):
        segment(SyntheticScan(points, pose), LAYOUT)


@pytest.mark.parametrize(
    "settings",
    [
        {"voxel": 0.0},
        {"rim_clearance": -0.001},
        {"cluster_gap": np.inf},
        {"cluster_share": 1.1},
        {"outlier_ratio": np.nan},
    ],
)
def test_settings_without_sense_are_refused(settings: dict[str, Any]) -> None:
    ((name, value),) = settings.items()
    with pytest.raises(beltsort.ArgumentError, match=rf"\b{name}\b.* {value}\b.*\b0\b"):
        PerceptionConfig(**settings)


def test_voxels_average_what_shares_a_cube() -> None:
    points = np.array([[0.011, 0.001, 0.0], [0.001, 0.001, 0.001], [0.003, 0.001, 0.001], [-0.001, 0.0, 0.0]])
    expected = [[-0.001, 0.0, 0.0], [0.002, 0.001, 0.001], [0.011, 0.001, 0.0]]
    assert np.allclose(voxel_means(points, 0.01), expected)
    assert voxel_means(np.empty((0, 3)), 0.01).shape == (0, 3)


def test_coarser_voxels_leave_fewer_points(scene: Scene) -> None:
    scan = scene.scan(scene.belt(), scene.ellipsoid(0, ROUND))
    sizes = [
        len(found(segment(scan, LAYOUT, PerceptionConfig(voxel=voxel)).candidates[0]))
        for voxel in (0.002, 0.004, 0.008)
    ]
    assert sizes == sorted(sizes, reverse=True)
    assert sizes[0] > 2 * sizes[2]
