"""The size of candidates, and descriptors with it."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from beltsort import ArgumentError
from beltsort.errors import CloudError, DatabaseError
from beltsort.geometry import BeltLayout, Points
from beltsort.perception import (
    NearestNeighbour,
    Perception,
    PerceptionConfig,
    describe,
    size_features,
    train_from_clouds,
)
from tests.laws import cases

from .cloud_folders import cloud_folder
from .databases import database

CAMERA = np.array([0.3, -0.2, 0.8])
RAISED = np.array([0.0, 0.0, 0.01])
SIZED = PerceptionConfig(descriptor="vfh+size")


def candidate(seed: int = 0) -> Points:
    """Return a cloud whose horizontal variances differ, belt frame."""
    rng = np.random.default_rng(seed)
    cloud: Points = rng.uniform(-1.0, 1.0, (300, 3)) * [0.06, 0.02, 0.03] + [0.18, 0.0, 0.1]
    return cloud


@cases(50)
@given(st.integers(0, 5), st.floats(0.0, 2.0 * np.pi), st.tuples(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0)))
def test_a_rotation_about_the_vertical_and_a_motion_along_the_belt_change_nothing(
    seed: int, angle: float, shift: tuple[float, float]
) -> None:
    cos, sin = np.cos(angle), np.sin(angle)
    rotation = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    moved, camera = (points @ rotation.T + [*shift, 0.0] for points in (candidate(seed), CAMERA))
    np.testing.assert_allclose(
        size_features(moved, camera), size_features(candidate(seed), CAMERA), atol=1e-9
    )


@cases(20)
@given(st.integers(0, 5), st.floats(0.1, 10.0))
def test_scaling_scales_them(seed: int, factor: float) -> None:
    here, there = size_features(candidate(seed), CAMERA), size_features(factor * candidate(seed), CAMERA)
    np.testing.assert_allclose(there, factor * here)


def test_raising_changes_the_height_only() -> None:
    here, there = size_features(candidate(), CAMERA), size_features(candidate() + RAISED, CAMERA)
    np.testing.assert_allclose(there - here, [0.01, 0.0, 0.0], atol=1e-12)


def test_the_order_of_points_does_not_matter() -> None:
    np.testing.assert_allclose(
        size_features(candidate()[::-1], CAMERA), size_features(candidate(), CAMERA), atol=1e-12
    )


def test_a_descriptor_with_size_begins_with_the_histogram() -> None:
    with_size, without = describe(candidate(), CAMERA, SIZED), describe(candidate(), CAMERA)
    assert with_size.shape == (311,)
    np.testing.assert_array_equal(with_size[:308], without)
    np.testing.assert_allclose(with_size[308:] / 1e4, size_features(candidate(), CAMERA))


def test_a_larger_object_of_the_same_shape_is_told_apart() -> None:
    def distance(config: PerceptionConfig) -> float:
        small, large = (describe(scale * candidate(), CAMERA, config) for scale in (1.0, 1.3))
        return NearestNeighbour.train([small], [0], ["small"], config).match(large).distance or 0.0

    assert distance(SIZED) > distance(PerceptionConfig()) + 20.0


@pytest.mark.parametrize(
    ("points", "camera", "said"),
    [
        (candidate(), (0.0, 0.0, 0.0), r"\bcamera\b.*z = 0 m.*belt frame"),
        (candidate() - [0.0, 0.0, 1.0], CAMERA, r"\btop\b.*-0\.8.*belt frame"),
        (candidate()[:2], CAMERA, "points"),
    ],
)
def test_another_frame_than_the_belts_is_told(points: Any, camera: Any, said: str) -> None:
    with pytest.raises(CloudError, match=said):
        size_features(points, camera)


def test_clouds_in_the_camera_frame_are_skipped_with_the_reason(tmp_path: Path) -> None:
    with pytest.raises(DatabaseError, match="belt frame"):
        train_from_clouds(cloud_folder(tmp_path / "clouds"), SIZED)


def test_clouds_in_the_belt_frame_are_trained_on(tmp_path: Path) -> None:
    trained = train_from_clouds(cloud_folder(tmp_path / "clouds"), SIZED, viewpoint=(0.0, 0.0, 1.5))
    assert trained.database.descriptors.shape == (6, 311)


def test_an_unknown_descriptor_is_refused() -> None:
    with pytest.raises(ArgumentError, match=r"'esf'.*'vfh', 'vfh\+size'"):
        PerceptionConfig(descriptor="esf")  # type: ignore[arg-type]  # what a file may say


def test_descriptors_of_another_kind_are_refused(tmp_path: Path) -> None:
    rows = [describe(candidate(seed), CAMERA, SIZED) for seed in range(3)]
    with pytest.raises(DatabaseError, match=r"\(3, 311\).*\(n, 308\).*vfh"):
        NearestNeighbour.train(rows, [0, 1, 2], ["a", "b", "c"])
    trained = NearestNeighbour.train(rows, [0, 1, 2], ["a", "b", "c"], SIZED)
    with pytest.raises(DatabaseError, match=r"\(308,\).*\(311,\)"):
        trained.match(describe(candidate(), CAMERA))
    with pytest.raises(DatabaseError, match=r"descriptor vfh \(database: vfh\+size\)"):
        Perception(BeltLayout(), trained, PerceptionConfig())
    trained.save(tmp_path / "sized.npz")
    loaded = NearestNeighbour.load(tmp_path / "sized.npz")
    assert loaded.config == SIZED
    np.testing.assert_array_equal(loaded.descriptors, trained.descriptors)


def test_a_database_of_version_2_has_no_size(tmp_path: Path) -> None:
    path = tmp_path / "old.npz"
    database().save(path)
    arrays: dict[str, Any] = dict(np.load(path))
    header = json.loads(str(arrays["header"]))
    del header["config"]["descriptor"]
    np.savez(path, **{**arrays, "header": np.array(json.dumps({**header, "version": 2}))})
    loaded = NearestNeighbour.load(path)
    assert loaded.config.descriptor == "vfh"
    np.testing.assert_array_equal(loaded.descriptors, database().descriptors)
