"""Depth images become clouds, with the intrinsics that lie beside them."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from beltsort.errors import CloudError
from beltsort.geometry import Points
from beltsort.perception import FileWarning, Intrinsics, cloud_from_depth, read_cloud
from beltsort.perception.clouds import files_of

FX, FY, CX, CY = 60.0, 65.0, 31.5, 23.5
MATRIX = [[FX, 0.0, CX], [0.0, FY, CY], [0.0, 0.0, 1.0]]
DEPTH: NDArray[np.uint16] = (600 + np.add.outer(np.arange(48), np.arange(64))).astype(np.uint16)
DEPTH[5, 7] = 0


def expected() -> Points:
    """The cloud of `DEPTH` in millimetres, one pixel after the other, shape (48 * 64, 3)."""
    points = [
        ((column - CX) * z / FX, (row - CY) * z / FY, z) if z else (np.nan,) * 3
        for row in range(48)
        for column in range(64)
        for z in [DEPTH[row, column] / 1000.0]
    ]
    return np.array(points)


def write_png(path: Path, depth: NDArray[np.uint16] = DEPTH) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(depth).save(path)
    return path


def test_every_pixel_is_a_point() -> None:
    for intrinsics in (Intrinsics(FX, FY, CX, CY), MATRIX):
        cloud = cloud_from_depth(DEPTH, intrinsics)
        assert cloud.shape == (48, 64, 3)
        np.testing.assert_allclose(cloud.reshape(-1, 3), expected())


def test_what_is_no_distance_is_no_return() -> None:
    depth = np.array([[0.5, np.nan, 0.0], [-0.1, np.inf, 0.7]])
    z = cloud_from_depth(depth, MATRIX, scale=1.0)[..., 2]
    np.testing.assert_array_equal(z, [[0.5, np.nan, np.nan], [np.nan, np.nan, 0.7]])


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ((np.zeros(3), MATRIX), r"\(3,\).*\(h, w\)"),
        ((np.zeros((2, 2)), np.eye(4)), r"\(3, 3\)"),
        ((np.zeros((2, 2)), np.zeros((3, 3))), "last row"),
        ((np.zeros((2, 2)), [[0, 0, 1], [0, 1, 1], [0, 0, 1]]), "fx, fy"),
        ((np.zeros((2, 2)), MATRIX, 0.0), r"scale is 0\.0"),
        (([["near"]], MATRIX), "depth"),
    ],
)
def test_what_makes_no_cloud_is_refused(arguments: tuple[Any, ...], said: str) -> None:
    with pytest.raises(CloudError, match=said):
        cloud_from_depth(*arguments)


BOP = {"cam_K": [FX, 0.0, CX, 0.0, FY, CY, 0.0, 0.0, 1.0]}
FOUR = {"fx": FX, "fy": FY, "cx": CX, "cy": CY}

SIZE = {"width": 64, "height": 48}
BY_COLUMNS = [FX, 0.0, 0.0, 0.0, FY, 0.0, CX, CY, 1.0]

CAMERAS: dict[str, tuple[str, dict[str, Any], float]] = {
    "realsense": ("7.json", {**SIZE, "fx": FX, "fy": FY, "ppx": CX, "ppy": CY, "coeffs": [0.0] * 5}, 1.0),
    "realsense, metres per unit": ("camera.json", {**FOUR, "depth_scale": 0.00025}, 4.0),
    "orbbec": ("intrinsics.json", {"rgb_intrinsic": {**FOUR, "fx": 900.0}, "depth_intrinsic": FOUR}, 1.0),
    "tum": ("camera.json", {**FOUR, "depth_scale": 5000.0}, 5.0),
    "bop, scene": ("../scene_camera.json", {"6": {"cam_K": [1] * 9}, "7": {**BOP, "depth_scale": 0.1}}, 10.0),
    "bop, data set": ("camera.json", {**FOUR, "depth_scale": 1.0, **SIZE}, 1.0),
    "open3d, by columns": ("camera.json", {**SIZE, "intrinsic_matrix": BY_COLUMNS}, 1.0),
    "ros": ("camera_info.json", {**SIZE, "K": BOP["cam_K"], "D": [0.0] * 5}, 1.0),
    "opencv": ("d435.json", {"camera_matrix": {"rows": 3, "cols": 3, "data": BOP["cam_K"]}}, 1.0),
}


@pytest.mark.parametrize("kind", CAMERAS)
def test_intrinsics_as_cameras_and_data_sets_write_them(tmp_path: Path, kind: str) -> None:
    name, content, factor = CAMERAS[kind]
    image = write_png(tmp_path / "depth" / "000007.png", (DEPTH * factor).astype(np.uint16))
    beside = image.parent / name.replace("7.json", "000007.json")
    beside.write_text(json.dumps(content))
    np.testing.assert_allclose(read_cloud(image), expected())
    assert [file.resolve() for file in files_of(image)] == [image, beside.resolve()]


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (None, r"intrinsics; write camera\.json\b.*\bfx, fy, cx, cy\b"),
        ({"width": 64}, r"camera\.json has no intrinsics"),
        ({**FOUR, "fx": 0.0}, r"camera\.json: .*\bfx\b"),
        ({**FOUR, "width": 640}, r"64 x 48\b.*\bwidth\b.*\b640\b"),
        ({**FOUR, "depth_scale": -1}, r"depth_scale\b.*-1"),
        ("torn", r"camera\.json is no readable JSON"),
    ],
)
def test_intrinsics_that_do_not_fit(tmp_path: Path, content: Any, said: str) -> None:
    image = write_png(tmp_path / "a.png")
    if content is not None:
        (tmp_path / "camera.json").write_text('{"fx": ' if content == "torn" else json.dumps(content))
    with pytest.raises(CloudError, match=rf"a\.png: .*{said}"):
        read_cloud(image)


def test_a_distortion_is_told(tmp_path: Path) -> None:
    image = write_png(tmp_path / "a.png")
    (tmp_path / "a.json").write_text(json.dumps({**FOUR, "coeffs": [0.1, 0.0, 0.0, 0.0, 0.0]}))
    with pytest.warns(FileWarning, match=r"distortion in a\.json"):
        read_cloud(image)


def test_images_that_are_no_depths(tmp_path: Path) -> None:
    (tmp_path / "camera.json").write_text(json.dumps(FOUR))
    Image.fromarray(np.zeros((48, 64, 3), np.uint8)).save(tmp_path / "colour.png")
    with pytest.raises(CloudError, match=r"colour\.png: .*\bRGB\b.*\b16-bit\b.*depth image"):
        read_cloud(tmp_path / "colour.png")
    content = write_png(tmp_path / "a.png").read_bytes()
    for share in (0.0, 0.3, 0.6, 0.8):  # at the end are checksums only
        (tmp_path / "a.png").write_bytes(content[: int(share * len(content))])
        with pytest.raises(CloudError, match=r"a\.png: .*16-bit PNG|a\.png holds"):
            read_cloud(tmp_path / "a.png")
    write_png(tmp_path / "a.png", np.zeros((48, 64), np.uint16))
    with pytest.raises(CloudError, match=r"\b3072 points\b.*finite"):
        read_cloud(tmp_path / "a.png")


def test_no_memory_for_an_empty_promise(tmp_path: Path) -> None:
    (tmp_path / "camera.json").write_text(json.dumps(FOUR))
    content = bytearray(write_png(tmp_path / "a.png").read_bytes())
    content[16:24] = (9000).to_bytes(4, "big") * 2
    content[29:33] = zlib_crc(bytes(content[12:29]))
    (tmp_path / "a.png").write_bytes(content)
    with pytest.raises(CloudError, match=r"9000 x 9000 pixels"):
        read_cloud(tmp_path / "a.png")


def zlib_crc(data: bytes) -> bytes:
    import zlib

    return zlib.crc32(data).to_bytes(4, "big")
