"""The file of the scans for a calibration: a line of JSON for each scan.

    {"file": "0.pcd", "marks": [[0, 0], [0.36, 0]], "world_from_camera": [[1, 0, 0, 0.5], ...]}

`file` holds the whole scan in the camera frame, in a format that `beltsort.perception.read_cloud` reads; its
path starts at the folder of this file. `marks` are the places of the objects on the belt, x upstream of the
belt end and y across, metres, the tallest object first; none if the belt is empty. The pose, a matrix of four
rows or `{"position": [x, y, z], "quaternion": [x, y, z, w]}`, is the camera's, or the flange's
(`world_from_flange`) to calibrate the hand-eye transform. A camera whose pose is not known must not move:
without poses, the camera frame takes the place of the robot's world frame.
"""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from os import PathLike
from pathlib import Path
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from beltsort.cell.frames import from_matrix, from_quaternion
from beltsort.errors import CloudError, RecordingError
from beltsort.extrinsics.landmarks import FARTHEST, Landmarks, find_landmarks
from beltsort.geometry import Points, Pose
from beltsort.perception import PoseCause, read_cloud
from beltsort.util.extras import extra
from beltsort.util.problems import Problem, listed
from beltsort.util.validation import StrictModel, shortened, validated

with extra("cell"):
    from pydantic import FiniteFloat, PlainValidator


@dataclass(frozen=True, eq=False)
class MarkedScan:
    """A scan of the belt with marks at known places.

    Attributes
    ----------
    file
        Its path in the file of scans.
    places
        Where the marks stand, belt frame, metres, shape (k, 2).
    landmarks
        What it shows; marks in the order of `places`.
    pose
        The camera's or the flange's pose in the world frame, shape (4, 4).
    """

    file: str
    places: Points
    landmarks: Landmarks
    pose: Pose


@dataclass(frozen=True)
class MarkedScans:
    """The scans of a file.

    Attributes
    ----------
    scans
        One or more.
    frame
        Whose poses they have: `camera`, `flange`, or `none`, where the camera frame is the world frame.
    """

    scans: tuple[MarkedScan, ...]
    frame: str


def _pose(given: object) -> Pose:
    """Return a pose from its plain data; raises `ValueError`."""
    try:
        match given:
            case {"position": position, "quaternion": quaternion, **rest} if not rest:
                pose = from_quaternion(_numbers(position, 3).tolist(), _numbers(quaternion, 4).tolist())
            case [_, _, _, _]:
                pose = from_matrix(_numbers(given, 4, 4).tolist())
            case _:
                raise TypeError
    except TypeError:
        raise ValueError(
            f"{shortened(given)} is no pose, expected four rows of four numbers, or position and quaternion"
        ) from None
    if np.linalg.norm(pose[:3, 3]) > FARTHEST:
        raise ValueError(
            f"the position is {pose[:3, 3].tolist()}, expected at most {FARTHEST:g} metres from the origin; "
            f"likely: {PoseCause.POSE_MM}"
        )
    return pose


def _numbers(given: object, *shape: int) -> NDArray[np.float64]:
    """Return finite numbers of a shape; raises `TypeError`."""
    try:
        numbers = np.array(given, dtype=np.float64)
    except ValueError as reason:
        raise TypeError from reason
    if numbers.shape != shape or not np.isfinite(numbers).all():
        raise TypeError
    return numbers


GivenPose = Annotated[Pose, PlainValidator(_pose)]


class ScanLine(StrictModel):
    """One line of the file."""

    file: str
    """Path of the cloud, from the folder of this file."""
    marks: tuple[tuple[FiniteFloat, FiniteFloat], ...] = ()
    """[x, y] of each object on the belt, metres, the tallest first."""
    world_from_camera: GivenPose | None = None
    """The camera's pose in the robot's world frame."""
    world_from_flange: GivenPose | None = None
    """The flange's pose in the robot's world frame."""

    @property
    def frame(self) -> str:
        """Whose pose the line has."""
        known = {"camera": self.world_from_camera, "flange": self.world_from_flange}
        return " and ".join(frame for frame, pose in known.items() if pose is not None) or "none"


def read_scans(path: str | PathLike[str]) -> MarkedScans:
    """Read the scans of a file, and find belt and marks in each.

    Raises
    ------
    RecordingError
        If the file cannot be read, a line is wrong, or lines have poses of different frames.
    CloudError
        If a cloud cannot be read, or does not show belt and marks.
    """
    lines = _lines(Path(path))
    frames = sorted({line.frame for line in lines})
    if len(frames) != 1 or " and " in frames[0]:
        raise RecordingError(
            f"{path} has lines with the poses of {', '.join(frames)}, expected world_from_camera in every "
            "line, or world_from_flange in every line, or none in all: correct them"
        )
    return MarkedScans(tuple(_scan(Path(path).parent, line) for line in lines), frames[0])


def _lines(path: Path) -> Sequence[ScanLine]:
    try:
        texts = path.read_text("utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as reason:
        raise RecordingError(f"cannot read {path}: {reason}; expected one line of JSON per scan") from reason
    lines = [_line(path, number, text) for number, text in enumerate(texts, start=1) if text.strip()]
    if not lines:
        raise RecordingError(f"{path} lists 0 scans, expected at least one: scan the belt")
    return lines


def _line(path: Path, number: int, text: str) -> ScanLine:
    try:
        row = json.loads(text)
    except ValueError as reason:
        raise RecordingError(f"{path}, line {number}: no JSON ({reason}); correct it") from reason
    return validated(ScanLine, row, partial(_invalid, path, number))


def _invalid(path: Path, number: int, problems: Sequence[Problem]) -> RecordingError:
    return RecordingError(f"{path}, line {number}: {listed(problems)}")


def _scan(folder: Path, line: ScanLine) -> MarkedScan:
    points = read_cloud(folder / line.file)
    try:
        landmarks = find_landmarks(points, len(line.marks))
    except CloudError as reason:
        raise CloudError(f"{folder / line.file}: {reason}") from reason
    pose = line.world_from_camera if line.frame == "camera" else line.world_from_flange
    places = np.array(line.marks, dtype=np.float64).reshape(-1, 2)
    return MarkedScan(line.file, places, landmarks, np.eye(4) if pose is None else pose)
