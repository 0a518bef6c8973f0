"""Samples of the half-sphere, and the cameras that stand there."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from beltsort import ArgumentError
from beltsort.geometry import SphereViewpoint, direction_of, look_at, on_sphere
from beltsort.viewpoints import Sampling
from beltsort.viewpoints.sphere import METHODS
from tests.laws import cases

law = cases(60)

SAMPLINGS = st.builds(
    Sampling,
    method=st.sampled_from(METHODS),
    count=st.integers(1, 300),
    radius=st.floats(0.1, 3.0),
    seed=st.integers(0, 2**64),
)
AZIMUTHS, ELEVATIONS = st.floats(-180.0, 180.0), st.floats(0.0, 90.0)


@law
@given(sampling=SAMPLINGS)
def test_every_point_is_on_the_upper_half_sphere(sampling: Sampling) -> None:
    points = sampling.points()
    assert points.shape == (sampling.count, 3)
    assert points[:, 2].min() >= 0.0
    np.testing.assert_allclose(np.linalg.norm(points, axis=-1), sampling.radius)


@pytest.mark.parametrize("count", [50, 100, 400])
def test_fibonacci_points_are_evenly_spread(count: int) -> None:
    points = Sampling("fibonacci", count, radius=1.0).points()
    angles = np.arccos(np.clip(points @ points.T, -1.0, 1.0)) + np.pi * np.eye(count)
    nearest = angles.min(axis=-1)
    assert nearest.max() / nearest.min() < 1.5
    hexagonal = np.sqrt(2.0 / np.sqrt(3.0) * 2.0 * np.pi / count)  # no packing is denser
    assert nearest.mean() > 0.85 * hexagonal


@law
@given(count=st.integers(1, 300))
def test_fibonacci_points_are_as_high_as_the_half_sphere_on_average(count: int) -> None:
    assert Sampling("fibonacci", count, radius=1.0).points()[:, 2].mean() == pytest.approx(0.5)


def test_uniform_points_are_reproducible_and_no_two_seeds_alike() -> None:
    first, again, other = (Sampling("uniform", seed=seed).points() for seed in (5, 5, 6))
    np.testing.assert_array_equal(first, again)
    assert np.abs(first - other).max() > 0.1


@pytest.mark.parametrize("of", [lambda p: p[:, 2], lambda p: direction_of(p)[0] / 360.0 + 0.5])
def test_uniform_points_have_uniform_heights_and_azimuths(of: Callable[..., np.ndarray]) -> None:
    count = 20_000
    drawn = np.sort(of(Sampling("uniform", count, radius=1.0, seed=1).points()))
    distance = np.abs(drawn - (np.arange(count) + 0.5) / count).max()
    assert distance < 1.95 / np.sqrt(count)  # Kolmogorov-Smirnov, 0.1 %


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"method": "spiral"}, r"method 'spiral'.*fibonacci, uniform"),
        ({"count": 0}, r"\bcount\b.*\b0\b.*\b1\b"),
        ({"radius": -0.7}, r"\bradius\b.*-0\.7\b.*\b0\b"),
        ({"radius": np.inf}, r"\bradius\b.*\binf\b"),
        ({"radius": np.nan}, r"\bradius\b.*\bnan\b"),
        ({"seed": -1}, r"\bseed\b.*-1\b"),
    ],
)
def test_what_cannot_be_sampled(wrong: dict[str, Any], message: str) -> None:
    with pytest.raises(ArgumentError, match=message):
        Sampling(**wrong)


@law
@given(azimuth=AZIMUTHS, elevation=ELEVATIONS, radius=st.floats(0.1, 3.0))
def test_a_camera_looks_at_the_belt_end(azimuth: float, elevation: float, radius: float) -> None:
    pose = SphereViewpoint("p", azimuth, elevation, radius).pose()
    turn, eye = pose[:3, :3], pose[:3, 3]
    np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(turn) == pytest.approx(1.0)
    np.testing.assert_allclose(eye + radius * turn[:, 2], 0.0, atol=1e-12)
    assert turn[2, 1] <= 1e-12  # the image's y points down
    np.testing.assert_array_equal(pose[3], [0.0, 0.0, 0.0, 1.0])


@law
@given(azimuth=AZIMUTHS, elevation=st.floats(0.0, 89.9), radius=st.floats(0.1, 3.0))
def test_a_point_has_the_direction_that_it_was_made_from(
    azimuth: float, elevation: float, radius: float
) -> None:
    point = on_sphere(azimuth, elevation, radius, np.zeros(3))
    seen_azimuth, seen_elevation = map(float, direction_of(point))
    again = on_sphere(seen_azimuth, seen_elevation, radius, np.zeros(3))
    np.testing.assert_allclose(again, point, atol=1e-12)
    assert seen_elevation == pytest.approx(elevation, abs=1e-9)


def test_straight_above_the_image_is_the_right_way_up() -> None:
    turn = look_at(np.array([0.0, 0.0, 0.7]), np.zeros(3))[:3, :3]
    np.testing.assert_allclose(-turn[:, 1], [1.0, 0.0, 0.0], atol=1e-12)
