"""Options that do not fit are refused before anything starts."""

import dataclasses
from typing import Any, NamedTuple

import numpy as np
import pytest

from beltsort.drivers.ros.options import SorterOptions
from beltsort.drivers.ros1.options import Ros1ArmOptions, Ros1CameraOptions, Ros1SorterOptions
from beltsort.drivers.ros2.options import Ros2ArmOptions, Ros2CameraOptions, Ros2SorterOptions
from beltsort.errors import CellError
from tests.drivers.ros.scenery import POSES, TAUGHT
from tests.drivers.ros1 import scene as scene1
from tests.drivers.ros2 import scene as scene2

pytestmark = pytest.mark.process

MASTER = "http://127.0.0.1:11311"


class Options(NamedTuple):
    """Options that fit, of each device."""

    camera_by_tf: Ros1CameraOptions | Ros2CameraOptions
    camera_by_joints: Ros1CameraOptions | Ros2CameraOptions
    arm: Ros1ArmOptions | Ros2ArmOptions
    arm_topic: str
    sorter: type[SorterOptions]


VERSIONS = {
    "Ros1": Options(
        scene1.camera_by_tf(MASTER),
        scene1.camera_by_joints(MASTER),
        scene1.arm(MASTER),
        "joint_command_topic",
        Ros1SorterOptions,
    ),
    "Ros2": Options(
        scene2.camera_by_tf(1),
        scene2.camera_by_joints(1),
        scene2.arm(1),
        "trajectory_topic",
        Ros2SorterOptions,
    ),
}


@pytest.fixture(params=VERSIONS)
def fitting(request: pytest.FixtureRequest) -> Options:
    return VERSIONS[request.param]


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"joint_topic": "/joint_states"}, r"world_frame\b.*'world'.*joint_topic\b.*'/joint_states'"),
        (
            {"world_frame": "", "taught": TAUGHT, "poses": POSES},
            r"world_frame\b.*''.*joint_topic\b.*''.*\['p1', 'p2'\]",
        ),
        (
            {
                "world_frame": "",
                "joint_topic": "/j",
                "taught": TAUGHT,
                "poses": {"p1": POSES["p1"]},
            },
            r"poses\b.*\['p1'\].*taught\b.*\['p1', 'p2'\]",
        ),
        ({"pose_age": 0.0}, r"\bpose_age\b.*\b0\.0\b.*\b0\b"),
    ],
)
def test_a_camera_whose_pose_is_not_known_or_twice(
    fitting: Options, changes: dict[str, Any], said: str
) -> None:
    with pytest.raises(CellError, match=said):
        dataclasses.replace(fitting.camera_by_tf, **changes)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"viewpoints": ("p1", "p3")}, r"taught\b.*\['p1', 'p2'\].*\['p1', 'p3'\]"),
        ({"taught": {**TAUGHT, "p2": {}}}, r"taught\.p2\b.*\{\}.*\['elbow', 'shoulder'\]"),
        (
            {"taught": {**TAUGHT, "p2": {"elbow": float("nan"), "shoulder": 0.0}}},
            r"taught\.p2\b.*\bnan\b.*\['elbow', 'shoulder'\]",
        ),
        ({"stalled": float("nan")}, r"\bstalled\b.*\bnan\b"),
        ({"flange_frame": "flange"}, r"world_frame\b.*''.*flange_frame\b.*'flange'"),
        ({"viewpoints": (), "taught": {}}, r"taught\b.*\[\].*\[\]"),
    ],
)
def test_an_arm_that_cannot_be_commanded(fitting: Options, changes: dict[str, Any], said: str) -> None:
    with pytest.raises(CellError, match=said):
        dataclasses.replace(fitting.arm, **changes)


def test_an_arm_that_is_commanded_twice_or_not_at_all(fitting: Options) -> None:
    topic = fitting.arm_topic
    with pytest.raises(CellError, match=rf"{topic}\b.*'/\S+'.*action\b.*'/arm'"):
        dataclasses.replace(fitting.arm, action="/arm")
    changes: dict[str, Any] = {topic: ""}
    with pytest.raises(CellError, match=rf"{topic}\b.*''.*action\b.*''"):
        dataclasses.replace(fitting.arm, **changes)


@pytest.mark.parametrize(
    "topics", [("/same", "/same", "/stop"), ("/command", "", "/stop"), ("/a", "/b", "/a")]
)
def test_a_sorter_that_would_hear_itself(fitting: Options, topics: tuple[str, str, str]) -> None:
    command, state, stop = topics
    with pytest.raises(CellError, match=rf"command_topic, state_topic and stop_topic\b.*'{stop}'"):
        fitting.sorter(command_topic=command, state_topic=state, stop_topic=stop)


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
def test_poses_that_are_none(fitting: Options, rows: list[list[float]]) -> None:
    with pytest.raises(CellError, match=r"poses\.p2\b.*\brigid\b.*\(4, 4\)"):
        dataclasses.replace(fitting.camera_by_joints, poses={**POSES, "p2": rows})
