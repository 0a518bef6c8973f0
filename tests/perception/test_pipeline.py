"""Scan -> labels, and the import's price."""

import subprocess
import sys
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from beltsort.errors import CloudError, DatabaseError
from beltsort.geometry import BeltLayout, on_sphere
from beltsort.perception import NearestNeighbour, Perception, PerceptionConfig, describe, segment
from beltsort.perception.descriptor import oriented_normals
from tests.perception.belt_scene import Scene

LAYOUT = BeltLayout()
SHAPES = {"round": (0.03, 0.03, 0.03), "tall": (0.015, 0.015, 0.05)}
CAMERA = on_sphere(60.0, 50.0, 0.7, np.zeros(3))


@pytest.fixture
def scene() -> Scene:
    return Scene(LAYOUT, np.random.default_rng(7))


def trained() -> NearestNeighbour:
    descriptors, labels = [], []
    for seed in range(3):
        scene = Scene(LAYOUT, np.random.default_rng(seed))
        for label, semi_axes in enumerate(SHAPES.values()):
            segmented = segment(scene.scan(scene.belt(), scene.ellipsoid(0, semi_axes)), LAYOUT)
            assert segmented.candidates[0] is not None
            descriptors.append(describe(segmented.candidates[0], segmented.camera))
            labels.append(label)
    return NearestNeighbour.train(descriptors, labels, list(SHAPES))


def test_labels_the_object_of_each_position(scene: Scene) -> None:
    perception = Perception(LAYOUT, trained())
    parts = scene.belt(), scene.ellipsoid(0, SHAPES["tall"]), scene.ellipsoid(1, SHAPES["round"])
    first, second = perception(scene.scan(*parts))
    assert (first.position, first.label, first.empty) == (0, 1, False)
    assert (second.position, second.label, second.empty) == (1, 0, False)
    assert first.distance is not None
    assert first.runner_up is not None
    assert 0.0 < first.distance < 0.5 * first.runner_up


def test_empty_is_not_unlabelled(scene: Scene) -> None:
    config = PerceptionConfig(fewest_labelled=10_000)
    database = replace(trained(), config=config)
    scan = scene.scan(scene.belt(), scene.cup(0), scene.cup(1), scene.ellipsoid(1, SHAPES["round"]))
    empty, unlabelled = Perception(LAYOUT, database, config)(scan)
    assert empty.empty
    assert empty.points is None
    assert not unlabelled.empty
    assert unlabelled.points is not None
    for nothing in (empty, unlabelled):
        assert (nothing.label, nothing.distance, nothing.runner_up) == (None, None, None)


def test_the_same_scan_gives_the_same_answer(scene: Scene) -> None:
    perception = Perception(LAYOUT, trained())
    scan = scene.scan(scene.belt(), scene.ellipsoid(0, SHAPES["tall"]))
    a, b = perception(scan)[0], perception(scan)[0]
    assert (a.label, a.distance, a.runner_up) == (b.label, b.distance, b.runner_up)
    candidate = segment(scan, LAYOUT).candidates[0]
    assert a.points is not None
    assert candidate is not None
    assert np.array_equal(candidate, a.points)


def test_another_configuration_than_the_databases_is_refused() -> None:
    with pytest.raises(DatabaseError, match=r"\bvoxel\b.*\b0\.01\b.*\b0\.004\b"):
        Perception(LAYOUT, trained(), PerceptionConfig(voxel=0.01))


def test_normals_are_unit_and_face_the_camera(scene: Scene) -> None:
    points = scene.ellipsoid(0, SHAPES["round"])
    normals = oriented_normals(points, CAMERA, 20)
    assert np.allclose(np.linalg.norm(normals, axis=1), 1.0)
    assert (np.einsum("ij,ij->i", normals, CAMERA - points) >= 0.0).all()


def test_normals_of_a_plane_are_exact() -> None:
    grid = np.array([[x, y, 0.5 * x] for x in np.linspace(0, 0.1, 12) for y in np.linspace(0, 0.1, 12)])
    expected = np.array([-0.5, 0.0, 1.0]) / np.sqrt(1.25)
    assert np.allclose(oriented_normals(grid, np.array([0.0, 0.0, 1.0]), 10), expected, atol=1e-6)


@pytest.mark.parametrize(
    ("points", "camera", "said"),
    [
        (np.empty((0, 3)), CAMERA, "0 points"),
        (np.eye(3)[:2], CAMERA, r"\b2 points\b.*\b3\b"),
        (np.full((10, 3), np.nan), CAMERA, r"points\b.*\b30 values\b"),
        ([], CAMERA, r"points\b.*\(0,\).*\(n, 3\)"),
        (np.zeros((5, 2)), CAMERA, r"points\b.*\(5, 2\).*\(n, 3\)"),
        ([[0.0, 0.0, 0.0], [1.0]], CAMERA, r"points\b.*inhomogeneous.*\bnumbers\b"),
        (np.eye(3), CAMERA[:2], r"viewpoint\b.*\(2,\).*\(3,\)"),
        (np.eye(3), (0.0, 0.0, np.nan), r"viewpoint\b.*\b1 values\b"),
    ],
)
def test_no_descriptor_without_surface_or_camera(points: Any, camera: Any, said: str) -> None:
    with pytest.raises(CloudError, match=said):
        describe(points, camera)


def test_lists_are_described_like_arrays(scene: Scene) -> None:
    points = scene.ellipsoid(0, SHAPES["round"])
    assert np.array_equal(describe(points.tolist(), CAMERA.tolist()), describe(points, CAMERA))


def test_importing_perception_does_not_import_open3d() -> None:
    code = "import sys, beltsort.perception; sys.exit('open3d' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
