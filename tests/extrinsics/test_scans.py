"""The file of scans, and the command that reads it."""

import json
import re
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from beltsort.cell.arrival import deviation
from beltsort.cell.frames import from_quaternion
from beltsort.cellfile.sections import Transform
from beltsort.errors import CloudError, RecordingError
from beltsort.extrinsics.scans import read_scans
from beltsort.geometry import inverse
from beltsort.util.validation import validated
from tests.cli.running import command, json_of, output
from tests.extrinsics.marked import PLACES, cloud, pose_of, poses, scene

WORLD_FROM_BELT = pose_of([0.0, 0.0, 1.5], [0.5, -0.2, 0.1])
CAMERAS = poses(2)
"""In the belt frame."""


def line(n: int, **keys: Any) -> dict[str, Any]:
    return {"file": f"{n}.npy", "marks": PLACES.tolist(), **keys}


def posed(n: int) -> dict[str, Any]:
    return line(n, world_from_camera=(WORLD_FROM_BELT @ CAMERAS[n]).tolist())


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("scans")
    for n, camera in enumerate(CAMERAS):
        np.save(folder / f"{n}.npy", cloud(scene(), camera, n))
    return folder


def written(folder: Path, *lines: dict[str, Any]) -> Path:
    path = folder / "scans.jsonl"
    path.write_text("\n".join(json.dumps(line) for line in lines) + "\n")
    return path


def test_lines_for_the_cell_file(folder: Path, tmp_path: Path) -> None:
    path = written(folder, posed(0), posed(1))
    assert "[belt]\nworld_from_belt = { position = [" in output("calibrate-belt", str(path))
    told = json_of("calibrate-belt", str(path), "-o", str(tmp_path / "belt.toml"))
    found = validated(Transform, told["world_from_belt"], lambda problems: RecordingError(str(problems)))
    assert not deviation(found.pose(), WORLD_FROM_BELT).exceeds(angle=0.3, distance=2.0)
    assert [scan["file"] for scan in told["scans"]] == ["0.npy", "1.npy"]
    assert (told["poses_of"], told["redundancy"]) == ("camera", 8)
    lines = tomllib.loads((tmp_path / "belt.toml").read_text())
    assert lines == {"belt": {"world_from_belt": told["world_from_belt"]}}


def test_without_a_pose_the_camera_frame_is_the_world(folder: Path) -> None:
    path = written(folder, line(1))
    told = output("calibrate-belt", str(path))
    assert "the world frame is the camera frame" in told
    assert "take more" in told
    found = from_quaternion(**json_of("calibrate-belt", str(path))["world_from_belt"])
    assert not deviation(found, inverse(CAMERAS[1])).exceeds(angle=0.3, distance=3.0)


def test_hand_eye(tmp_path: Path) -> None:
    flange_from_camera = pose_of([0.05, -0.1, 0.8], [0.02, 0.05, 0.03])
    lines = []
    for n, camera in enumerate(poses(4)):
        np.save(tmp_path / f"{n}.npy", cloud(scene(), camera, n))
        flange = WORLD_FROM_BELT @ camera @ inverse(flange_from_camera)
        lines.append(line(n, world_from_flange=flange.tolist()))
    path = written(tmp_path, *lines)
    assert output("calibrate-belt", str(path), "--hand-eye").count("{ position = [") == 2
    told = json_of("calibrate-belt", str(path), "--hand-eye")
    for key, expected in (
        ("flange_from_camera", flange_from_camera),
        ("world_from_belt", WORLD_FROM_BELT),
    ):
        assert not deviation(from_quaternion(**told[key]), expected).exceeds(angle=0.4, distance=3.0)
    done = command("calibrate-belt", str(path))
    assert (done.returncode, "poses of the flange: add --hand-eye" in done.stderr) == (2, True)
    done = command("calibrate-belt", str(written(tmp_path, posed(0))), "--hand-eye")
    assert (done.returncode, "needs world_from_flange in every line" in done.stderr) == (2, True)


def test_the_lines_of_the_documentation(folder: Path) -> None:
    lines = re.findall(
        r'^\{"file".*', (Path(__file__).parents[2] / "docs/cell.md").read_text("utf-8"), re.MULTILINE
    )
    assert len(lines) >= 2
    for text in lines:
        given = json.loads(text) | {"file": "0.npy"}
        assert read_scans(written(folder, given)).frame != "none"


def test_what_is_wrong_is_told(folder: Path) -> None:
    pose = posed(0)["world_from_camera"]
    mirrored = np.diag([1.0, -1.0, 1.0, 1.0]).tolist()
    far = {"position": [500.0, 0.0, 900.0], "quaternion": [0.0, 0.0, 0.0, 1.0]}
    for lines, message in (
        ([], "lists 0 scans"),
        ([{"fil": "0.npy"}], "line 1: file: is missing"),
        ([posed(0), line(1, mark=[0, 0])], "line 2: mark: is an unknown key; did you mean 'marks'"),
        ([line(0, world_from_camera=pose[:3])], "world_from_camera: .* is no pose, expected four rows"),
        ([line(0, world_from_camera="here")], "is no pose"),
        ([line(0, world_from_camera=mirrored)], "no rigid transform, expected a right-handed rotation"),
        ([line(0, world_from_camera=far)], "likely: the pose is in millimetres"),
        ([posed(0), line(1)], "poses of camera, none, expected world_from_camera in every line"),
        ([line(0, marks=[0, 0])], r"line 1: marks\[0\]: is 0"),
    ):
        with pytest.raises(RecordingError, match=message):
            read_scans(written(folder, *lines))
    with pytest.raises(RecordingError, match="expected one line of JSON per scan"):
        read_scans(folder / "absent.jsonl")
    with pytest.raises(CloudError, match=r"0.npy: on the largest plane there is .* expected 1 marks"):
        read_scans(written(folder, line(0, marks=[[0, 0]])))
    done = command("calibrate-belt", str(written(folder, {"file": "0.npy"})))
    assert done.returncode == 2
    assert "expected at least two places" in done.stderr
