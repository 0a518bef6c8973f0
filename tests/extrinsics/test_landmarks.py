"""The belt and the marks on it in one cloud."""

import numpy as np
import pytest

from beltsort.errors import CloudError
from beltsort.extrinsics.landmarks import find_landmarks
from beltsort.geometry import Points, Pose, inverse, transform
from tests.extrinsics.marked import HEIGHTS, PLACES, cloud, poses, scene

POSE: Pose = poses(3)[1]


@pytest.fixture(scope="module")
def points() -> Points:
    return cloud(scene(), POSE)


def test_marks_are_found_under_their_tops(points: Points) -> None:
    found = find_landmarks(points, 2)
    np.testing.assert_allclose(transform(POSE, found.marks)[:, :2], PLACES, atol=0.003)
    np.testing.assert_allclose(POSE[:3, :3] @ found.normal, [0.0, 0.0, 1.0], atol=0.003)
    assert abs(transform(POSE, found.centre)[2]) < 0.001
    assert found.rms < 0.002
    assert found.share > 0.8


def test_the_same_cloud_gives_the_same_marks(points: Points) -> None:
    """RANSAC may draw other samples, but what it finds is refined."""
    first, second = (find_landmarks(points, 2) for _ in range(2))
    np.testing.assert_allclose(first.marks, second.marks, atol=1e-4)


def test_a_larger_floor_and_machines_beside_the_belt_are_passed_over(points: Points) -> None:
    rng = np.random.default_rng(0)
    floor = np.column_stack([rng.uniform(-1.0, 1.0, (2 * len(points), 2)), np.full(2 * len(points), -0.6)])
    beside = np.array([0.2, 0.4, 0.0]) + rng.uniform(0.0, 0.1, (3000, 3))
    around = transform(inverse(POSE), np.vstack([floor, beside]))
    found = find_landmarks(np.vstack([points, around, [[np.nan] * 3]]), 2)
    np.testing.assert_allclose(transform(POSE, found.marks)[:, :2], PLACES, atol=0.003)


def test_what_is_wrong_is_told(points: Points) -> None:
    blob = np.random.default_rng(0).normal([0.0, 0.0, 5.0], size=(5000, 3))
    alike = cloud(scene(heights=(HEIGHTS[0], HEIGHTS[0] - 0.002)), POSE)
    for given, count, message in (
        (1000.0 * points, 2, "the points are in millimetres"),
        (points, 1, r"there is 2 objects \(12\d, 7\d mm high\), expected 1 marks"),
        (cloud(scene(heights=()), POSE), 2, "there is nothing, expected 2 marks"),
        (alike, 2, "expected differences of 15 mm"),
        (blob, 2, "no plane contains 5% of the 5000 points"),
        (blob[:2], 0, "no plane"),
    ):
        with pytest.raises(CloudError, match=message):
            find_landmarks(given, count)
