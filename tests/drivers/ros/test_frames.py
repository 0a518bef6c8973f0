"""Frames: chains, times, and what is wrong with them."""

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from beltsort.drivers.ros.frames import Frames, quaternion_of, rigid
from beltsort.errors import CellError

STILL = [0.0, 0.0, 0.0, 1.0]
coordinates = st.floats(-1.0, 1.0, allow_subnormal=False)
quaternions = st.tuples(coordinates, coordinates, coordinates, coordinates).filter(
    lambda q: np.linalg.norm(q) > 0.1
)


def normalised(quaternion: tuple[float, ...]) -> list[float]:
    norm = float(np.linalg.norm(quaternion))
    return [value / norm for value in quaternion]


@given(quaternions, st.tuples(coordinates, coordinates, coordinates))
def test_a_pose_survives_its_quaternion(
    quaternion: tuple[float, ...], origin: tuple[float, float, float]
) -> None:
    pose = rigid(origin, normalised(quaternion))
    np.testing.assert_allclose(pose[:3, :3] @ pose[:3, :3].T, np.eye(3), atol=1e-14)
    assert np.linalg.det(pose) == pytest.approx(1.0)
    np.testing.assert_allclose(rigid(origin, quaternion_of(pose)), pose, atol=4e-15)


@given(quaternions, quaternions)
def test_frames_may_meet_below_neither(a: tuple[float, ...], b: tuple[float, ...]) -> None:
    frames = Frames()
    to_world, to_camera = normalised(a), normalised(b)
    frames.add("/base", "/world", None, [1.0, 2.0, 3.0], to_world)
    frames.add("base", "arm", None, [0.0, 0.5, 0.0], to_camera)
    frames.add("arm", "camera", 7.0, [0.0, 0.0, 0.1], STILL)
    through_base = rigid([0.0, 0.5, 0.0], to_camera) @ rigid([0.0, 0.0, 0.1], STILL)
    by_world = rigid([1.0, 2.0, 3.0], to_world) @ frames.pose("world", "camera", 7.0)
    np.testing.assert_allclose(by_world, through_base, atol=1e-14)


def test_the_nearest_time_counts_and_the_past_is_forgotten() -> None:
    frames = Frames(age=0.2)
    for time in (0.0, 12.0, 12.1, 12.3):
        frames.add("world", "camera", time, [time, 0.0, 0.0], STILL)
    assert frames.pose("world", "camera", 12.14)[0, 3] == 12.1
    assert frames.pose("world", "camera", 12.45)[0, 3] == 12.3
    with pytest.raises(CellError, match=r"'camera'.*'world'.*\b0\.000\b.*\b12\.000 s\b.*\b0\.2 s\b"):
        frames.pose("world", "camera", 0.0)


def test_frames_that_do_not_meet() -> None:
    frames = Frames()
    frames.add("base", "camera", None, [0.0, 0.0, 0.0], STILL)
    with pytest.raises(CellError, match=r"'camera'.*'world'.*'base' and 'world'.*\bcamera in base\b"):
        frames.pose("world", "camera", 0.0)


def test_a_circle_is_refused() -> None:
    frames = Frames()
    frames.add("a", "b", None, [0.0, 0.0, 0.0], STILL)
    frames.add("b", "a", None, [0.0, 0.0, 0.0], STILL)
    with pytest.raises(CellError, match=r"\['a', 'b'\]"):
        frames.pose("world", "a", 0.0)


@pytest.mark.parametrize(
    ("translation", "quaternion"),
    [
        ([0.0, 0.0, float("nan")], STILL),
        ([0.0] * 3, [0.0] * 4),
        ([0.0] * 3, [0.0, 0.0, 0.0, 1.1]),
        ([0.0] * 3, [float("nan")] * 4),
    ],
)
def test_what_is_no_rigid_transform(translation: list[float], quaternion: list[float]) -> None:
    with pytest.raises(
        CellError, match=rf"{re.escape(str(translation))}.*{re.escape(str(quaternion))}.*\b1\b"
    ):
        Frames().add("world", "camera", 0.0, translation, quaternion)
