"""Files of kinds that readers get wrong (tests/cases/clouds): read whole, or refused with what to do."""

import re
import warnings
from pathlib import Path

import numpy as np
import pytest

from beltsort.errors import CloudError
from beltsort.geometry import Points
from beltsort.perception import FileWarning, PerceptionConfig, describe, read_cloud
from beltsort.perception.cameras import CameraPositions
from beltsort.perception.training import read_view

FOLDER = Path(__file__).parents[1] / "cases" / "clouds"
PLAIN: Points = np.loadtxt(FOLDER / "plain.xyz")

WHOLE = {
    *(
        "plain.xyz",
        "lower_type.pcd",
        "v5_columns.pcd",
        "upper.pcd",
        "compressed_stored.pcd",
        "list_in_vertex.ply",
    ),
    *("face_first.ply", "cr_only.ply", "blank_between.ply", "header.xyz", "slash_header.xyz", "comma.xyz"),
    *("bom.xyz", "cloud.csv", "cloud.txt", "cloud.asc", "structured.npy"),
}
"""Files that hold the points of plain.xyz, every one."""

WITHOUT_RETURN = {"nan_ind.pcd": 3, "nan_qnan.pcd": 3, "fltmax.pcd": 3, "nan_ind.xyz": 1}
"""Files with these points among others that are no numbers, and how many of these."""

REFUSED = {
    "points_line_wrong.pcd": r"points_line_wrong\.pcd: .*\b40\b.*\b1080\b",
    "all_nan.pcd": r"\b1092 points\b.*\b0\b.*finite",
    "format_line_missing.ply": r"'format'.*\bascii\b",
    "trailing_comma.xyz": r"line 1: .*','",
    "ragged.xyz": r"line 51: .*\b2 columns\b.*\b3\b",
    "depth.png": r"intrinsics; write camera\.json",
    "cloud.npz": r"'\.npz'.*np\.save",
}


def test_every_file_is_tested() -> None:
    others = {"viewpoint.pcd", "utm.pcd", "xyzw.npy", "lefthanded.ply"}
    assert {file.name for file in FOLDER.iterdir()} == WHOLE | {*WITHOUT_RETURN} | {*REFUSED} | others


@pytest.mark.filterwarnings("ignore::beltsort.perception.FileWarning")
@pytest.mark.parametrize("name", sorted(WHOLE))
def test_all_points_are_read(name: str) -> None:
    np.testing.assert_allclose(read_cloud(FOLDER / name), PLAIN, atol=1e-7)


@pytest.mark.parametrize("name", WITHOUT_RETURN)
def test_what_is_no_number_is_no_return(name: str) -> None:
    points = read_cloud(FOLDER / name)
    missing = ~np.isfinite(points).all(axis=1)
    assert missing.sum() == WITHOUT_RETURN[name]
    kept = {tuple(point) for point in np.round(PLAIN, 6).tolist()}
    assert {tuple(point) for point in np.round(points[~missing], 6).tolist()} <= kept
    assert len(points) - missing.sum() >= len(PLAIN) - 3


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_not_read_says_what_to_do(name: str) -> None:
    with pytest.raises(CloudError, match=REFUSED[name]) as raised:
        read_cloud(FOLDER / name)
    assert not re.search(r"could not convert|dtype|not enough values|loadtxt|KeyError", str(raised.value))


def test_large_coordinates_keep_their_millimetres() -> None:
    points = read_cloud(FOLDER / "utm.pcd")
    assert len(points) == len(PLAIN)
    np.testing.assert_allclose(np.ptp(points, axis=0), np.ptp(PLAIN, axis=0), atol=1e-3)


def test_a_camera_far_from_the_object_is_told() -> None:
    with pytest.warns(FileWarning, match=r"utm\.pcd: .*--viewpoint"):
        read_view(FOLDER / "utm.pcd", PerceptionConfig(), CameraPositions())


def test_organised_arrays_with_a_fourth_column() -> None:
    np.testing.assert_allclose(read_cloud(FOLDER / "xyzw.npy"), PLAIN[:1080], atol=1e-7)


def test_left_handed_points_are_read_as_they_are() -> None:
    np.testing.assert_allclose(read_cloud(FOLDER / "lefthanded.ply"), PLAIN * [1, -1, 1], atol=1e-7)


def test_the_camera_stands_at_the_viewpoint_of_a_file() -> None:
    config = PerceptionConfig()
    here = read_view(FOLDER / "plain.xyz", config, CameraPositions())
    there = read_view(FOLDER / "viewpoint.pcd", config, CameraPositions())
    assert (here.own_viewpoint, there.own_viewpoint) == (False, True)
    np.testing.assert_allclose(there.camera, [1.5, -0.7, -0.4])
    own = describe(there.points, there.camera, config)
    as_if_at_the_origin = describe(there.points, np.zeros(3), config)
    expected = describe(here.points, here.camera, config)
    assert np.abs(own - expected).sum() < 0.2 * np.abs(as_if_at_the_origin - expected).sum()


def test_a_viewpoint_that_is_not_used_is_told() -> None:
    given = CameraPositions(np.array([0.0, 0.0, 0.5]))
    with pytest.warns(FileWarning, match=r"viewpoint\.pcd: .*\b1\.5 -0\.7 -0\.4\b.*\b0 0 0\.5\b"):
        seen = read_view(FOLDER / "viewpoint.pcd", PerceptionConfig(), given)
    np.testing.assert_array_equal(seen.camera, [0.0, 0.0, 0.5])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        read_view(FOLDER / "plain.xyz", PerceptionConfig(), given)


@pytest.mark.parametrize(("name", "faces"), [("face_first.ply", 1), ("../meshes/quads.ply", 96)])
def test_a_cloud_with_faces_is_told(name: str, faces: int) -> None:
    with pytest.warns(FileWarning, match=rf"\b{faces} faces\b.*--meshes"):
        read_cloud(FOLDER / name)
