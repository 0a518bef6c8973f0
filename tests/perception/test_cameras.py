"""Where the camera stood for each cloud, and what is said when that is given twice."""

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from beltsort.errors import CloudError
from beltsort.geometry import Points
from beltsort.perception import FileWarning, describe, train_from_clouds
from beltsort.perception.cameras import CameraPositions, read_camera_positions
from beltsort.perception.training import read_candidate

from .cloud_folders import SHAPES, cloud, cloud_folder

SHIFT = np.array([0.04, -0.08, 0.12])  # whole voxels


def write_pcd(path: Path, points: Points, viewpoint: Points) -> None:
    words = " ".join(map(str, viewpoint))
    head = (
        f"FIELDS x y z\nSIZE 8 8 8\nTYPE F F F\nWIDTH {len(points)}\nHEIGHT 1\nVIEWPOINT {words} 1 0 0 0\n"
        "DATA binary\n"
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(head.encode() + points.astype("<f8").tobytes())


def test_training_uses_the_viewpoint_of_each_file(tmp_path: Path) -> None:
    for name in SHAPES:
        for seed in range(2):
            points = cloud(name, seed)
            write_pcd(
                tmp_path / "moved" / name / f"{seed}.pcd", points + (1 + seed) * SHIFT, (1 + seed) * SHIFT
            )
            write_pcd(tmp_path / "plain" / name / f"{seed}.pcd", points, np.zeros(3))
    moved, plain = (train_from_clouds(tmp_path / folder) for folder in ("moved", "plain"))
    with pytest.warns(FileWarning, match=r"\bVIEWPOINT\b.*\b1 1 1\b"):
        ignoring = train_from_clouds(tmp_path / "moved", viewpoint=CameraPositions(np.ones(3)))
    assert (moved.own_viewpoints, plain.own_viewpoints, ignoring.own_viewpoints) == (4, 0, 0)
    error, worse = (
        np.abs(other.database.descriptors - plain.database.descriptors).sum() for other in (moved, ignoring)
    )
    assert error < 0.1 * worse


@pytest.mark.parametrize("separator", [",", " ", "\t", ";"])
def test_positions_from_a_file(tmp_path: Path, separator: str) -> None:
    folder = cloud_folder(tmp_path / "clouds", each=2)
    rows = [
        separator.join([file.relative_to(tmp_path).as_posix(), "0.1", "-0.2", "0.3"])
        for file in sorted(folder.rglob("*.npy"))[:-1]
    ]
    title = separator.join(["cloud", "x", "y", "z"])
    (tmp_path / "cameras.csv").write_text("\n".join([title, "# of the first day", "", *rows]))
    positions = read_camera_positions(tmp_path / "cameras.csv")
    trained = train_from_clouds(folder, viewpoint=positions)
    (skipped,) = trained.skipped
    assert (skipped.path.name, skipped.path.parent.name) == ("1.npy", "round")
    assert "camera position" in skipped.reason
    expected = describe(read_candidate(trained.files[0], trained.database.config), (0.1, -0.2, 0.3))
    np.testing.assert_array_equal(trained.database.descriptors[0], expected)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("", "0 camera positions"),
        ("cloud,x,y,z\n", "0 camera positions"),
        ("a.npy,1,2,3\nb.npy,1,two,3\n", r"line 2: 'b\.npy,1,two,3'"),
        ("a.npy,1,2\n", r"line 1: 'a\.npy,1,2'"),
        ("a.npy,1,2,inf\n", "line 1"),
    ],
)
def test_a_file_of_positions_that_is_not_understood(tmp_path: Path, content: str, said: str) -> None:
    (tmp_path / "cameras.csv").write_text(content)
    with pytest.raises(CloudError, match=rf"cameras\.csv.*{said}"):
        read_camera_positions(tmp_path / "cameras.csv")


def test_a_missing_file_of_positions(tmp_path: Path) -> None:
    with pytest.raises(CloudError, match=r"absent\.csv\b.*\bpath, x, y and z\b"):
        read_camera_positions(tmp_path / "absent.csv")


def test_depth_images_are_trained_on_with_their_intrinsics(tmp_path: Path) -> None:
    for name, (_, long, high) in {"flat": (0, 200, 20), "round": (0, 90, 90)}.items():
        for seed in range(2):
            depth = np.zeros((240, 320), np.uint16)
            depth[20 : 20 + high, 30 : 30 + long] = 600 + seed + np.arange(long) // 4
            (tmp_path / name).mkdir(exist_ok=True)
            Image.fromarray(depth).save(tmp_path / name / f"{seed}.png")
    camera = {"fx": 300.0, "fy": 300.0, "cx": 160.0, "cy": 120.0, "width": 320, "height": 240}
    (tmp_path / "camera.json").write_text(json.dumps(camera))
    trained = train_from_clouds(tmp_path)
    assert trained.database.labels.tolist() == [0, 0, 1, 1]
    assert trained.skipped == ()


def test_two_files_of_one_name_are_told(tmp_path: Path) -> None:
    folder = cloud_folder(tmp_path / "clouds")
    write_pcd(folder / "long" / "1.pcd", cloud("long", 1), np.zeros(3))
    with pytest.warns(FileWarning, match=r"long: 1\.npy and 1\.pcd\b"):
        assert len(train_from_clouds(folder).files) == 7
