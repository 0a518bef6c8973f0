"""Options that do not fit are refused before anything starts; what tells arrivals is tried without ROS."""

import dataclasses
from typing import Any

import numpy as np
import pytest

from beltsort.drivers.ros.standstill import Motion, Standstill
from beltsort.drivers.ros1.options import Ros1ArmOptions, Ros1CameraOptions, Ros1SorterOptions
from beltsort.errors import CellError
from tests.drivers.ros1 import scene

pytestmark = pytest.mark.process

MASTER = "http://127.0.0.1:11311"


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"joint_topic": "/joint_states"}, r"world_frame\b.*'world'.*joint_topic\b.*'/joint_states'"),
        (
            {"world_frame": "", "taught": scene.TAUGHT, "poses": scene.POSES},
            r"world_frame\b.*''.*joint_topic\b.*''.*\['p1', 'p2'\]",
        ),
        (
            {
                "world_frame": "",
                "joint_topic": "/j",
                "taught": scene.TAUGHT,
                "poses": {"p1": scene.POSES["p1"]},
            },
            r"poses\b.*\['p1'\].*taught\b.*\['p1', 'p2'\]",
        ),
        ({"pose_age": 0.0}, r"\bpose_age\b.*\b0\.0\b.*\b0\b"),
    ],
)
def test_a_camera_whose_pose_is_not_known_or_twice(changes: dict[str, Any], said: str) -> None:
    options: Ros1CameraOptions = scene.camera_by_tf(MASTER)
    with pytest.raises(CellError, match=said):
        dataclasses.replace(options, **changes)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"action": "/arm"}, r"joint_command_topic\b.*'/\S+'.*action\b.*'/arm'"),
        ({"joint_command_topic": ""}, r"joint_command_topic\b.*''.*action\b.*''"),
        ({"viewpoints": ("p1", "p3")}, r"taught\b.*\['p1', 'p2'\].*\['p1', 'p3'\]"),
        ({"taught": {**scene.TAUGHT, "p2": {}}}, r"taught\.p2\b.*\{\}.*\['elbow', 'shoulder'\]"),
        (
            {"taught": {**scene.TAUGHT, "p2": {"elbow": float("nan"), "shoulder": 0.0}}},
            r"taught\.p2\b.*\bnan\b.*\['elbow', 'shoulder'\]",
        ),
        ({"stalled": float("nan")}, r"\bstalled\b.*\bnan\b"),
        ({"flange_frame": "flange"}, r"world_frame\b.*''.*flange_frame\b.*'flange'"),
        ({"viewpoints": (), "taught": {}}, r"taught\b.*\[\].*\[\]"),
    ],
)
def test_an_arm_that_cannot_be_commanded(changes: dict[str, Any], said: str) -> None:
    options: Ros1ArmOptions = scene.arm(MASTER)
    with pytest.raises(CellError, match=said):
        dataclasses.replace(options, **changes)


@pytest.mark.parametrize(
    "topics", [("/same", "/same", "/stop"), ("/command", "", "/stop"), ("/a", "/b", "/a")]
)
def test_a_sorter_that_would_hear_itself(topics: tuple[str, str, str]) -> None:
    command, state, stop = topics
    with pytest.raises(CellError, match=rf"command_topic, state_topic and stop_topic\b.*'{stop}'"):
        Ros1SorterOptions(command_topic=command, state_topic=state, stop_topic=stop)


@pytest.mark.parametrize(
    "rows",
    [
        [[1.0, 0.0], [0.0, 1.0]],
        [[1.0]],
        [[1.0, 0.0, 0.0, 0.0], [0.0]],
        (-np.eye(4)).tolist(),
        (2.0 * np.eye(4)).tolist(),
        np.diag([1.0, 1.0, -1.0, 1.0]).tolist(),
        np.full((4, 4), np.nan).tolist(),
    ],
)
def test_poses_that_are_none(rows: list[list[float]]) -> None:
    with pytest.raises(CellError, match=r"poses\.p2\b.*\brigid\b.*\(4, 4\)"):
        dataclasses.replace(scene.camera_by_joints(MASTER), poses={**scene.POSES, "p2": rows})


def seen(*states: tuple[float, float]) -> list[Motion]:
    watch = Standstill({"elbow": 1.0}, tolerance=0.02, still=0.2, stalled=2.0)
    return [watch.see(time, {"elbow": at}) for time, at in states]


def test_passing_by_is_not_arriving() -> None:
    assert set(seen((0.0, 0.98), (0.1, 0.99), (0.2, 1.0), (0.3, 1.01), (0.4, 1.02))) == {Motion.MOVING}


def test_trembling_at_the_target_is_arriving() -> None:
    assert seen((0.0, 1.001), (0.1, 0.999), (0.2, 1.001))[-1] is Motion.ARRIVED


def test_creeping_is_moving() -> None:
    states = [(0.1 * n, 0.5 + 0.001 * n) for n in range(40)]
    assert Motion.ELSEWHERE not in seen(*states)


def test_standing_elsewhere_takes_longer_unless_the_motion_has_ended() -> None:
    *before, last = seen((0.0, 0.5), (0.9, 0.5), (1.8, 0.5), (2.0, 0.5))
    assert {*before} == {Motion.MOVING}
    assert last is Motion.ELSEWHERE
    watch = Standstill({"elbow": 1.0}, tolerance=0.02, still=0.2, stalled=2.0)
    watch.see(0.0, {"elbow": 0.5})
    watch.expect_no_more()
    assert watch.see(0.2, {"elbow": 0.5}) is Motion.ELSEWHERE


def test_a_silence_does_not_prove_that_the_arm_stood_still() -> None:
    assert seen((0.0, 0.5), (5.0, 0.5)) == [Motion.MOVING, Motion.MOVING]
