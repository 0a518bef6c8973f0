"""Files: what is whole is read exactly, what is not is one clear error."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from beltsort.errors import CloudError
from beltsort.geometry import Points
from beltsort.perception import read_cloud

CLOUD: Points = np.random.default_rng(0).normal(size=(50, 3)).astype(np.float32).astype(np.float64)
CLOUD[7] = np.nan


def open3d_file(path: Path, *, ascii_text: bool = False, compressed: bool = False) -> None:
    import open3d as o3d

    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(CLOUD))
    assert o3d.io.write_point_cloud(path, cloud, write_ascii=ascii_text, compressed=compressed)


WRITERS: dict[str, Callable[[Path], None]] = {
    "text.pcd": lambda path: open3d_file(path, ascii_text=True),
    "binary.pcd": open3d_file,
    "compressed.pcd": lambda path: open3d_file(path, compressed=True),
    "text.ply": lambda path: open3d_file(path, ascii_text=True),
    "binary.ply": open3d_file,
    "text.xyz": lambda path: np.savetxt(path, CLOUD),
    "array.npy": lambda path: np.save(path, CLOUD),
}


@pytest.mark.parametrize("name", WRITERS)
def test_reads_what_others_write(tmp_path: Path, name: str) -> None:
    WRITERS[name](tmp_path / name)
    assert np.allclose(read_cloud(tmp_path / name), CLOUD, rtol=1e-5, equal_nan=True)


@pytest.mark.parametrize("share", [0.0, 0.2, 0.6, 0.95])
@pytest.mark.parametrize("name", [name for name in WRITERS if name != "text.xyz"])
def test_a_truncated_file_is_a_cloud_error(tmp_path: Path, name: str, share: float) -> None:
    path = tmp_path / name
    WRITERS[name](path)
    content = path.read_bytes()
    path.write_bytes(content[: int(share * len(content))])
    with pytest.raises(CloudError, match=name):
        read_cloud(path)


def test_reads_an_organised_array_and_further_columns(tmp_path: Path) -> None:
    np.save(tmp_path / "image.npy", np.arange(24).reshape(2, 4, 3))
    assert np.array_equal(read_cloud(tmp_path / "image.npy"), np.arange(24).reshape(8, 3))
    (tmp_path / "normals.xyz").write_text("# x y z nx ny nz\n1 2 3 0 0 1\n4 5 6 0 0 1\n")
    assert np.array_equal(read_cloud(tmp_path / "normals.xyz"), [[1, 2, 3], [4, 5, 6]])


def test_reads_records_with_other_fields_between(tmp_path: Path) -> None:
    records = np.zeros(2, [("i", "<u2"), ("x", "<f8"), ("n", "<f4", (3,)), ("y", "<f8"), ("z", "<f4")])
    records["x"], records["y"], records["z"] = [1, 2], [3, 4], [5, 6]
    header = (
        "# .PCD v0.7\nVERSION 0.7\nFIELDS _ x normal y z\nSIZE 2 8 4 8 4\nTYPE U F F F F\nCOUNT 1 1 3 1 1\n"
        "WIDTH 2\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\nDATA binary\n"
    )
    (tmp_path / "a.pcd").write_bytes(header.encode() + records.tobytes())
    assert np.array_equal(read_cloud(tmp_path / "a.pcd"), [[1, 3, 5], [2, 4, 6]])


HEAD = (
    "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n"
    "WIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA ascii\n"
)
HUGE = "1000000000000"


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("a.pcd", HEAD.replace("POINTS 1", "POINTS 0"), "0 points"),
        ("a.pcd", HEAD.replace("POINTS 1", "POINTS -1") + "1 2 3\n", "-1 points"),
        ("a.pcd", HEAD.replace("POINTS 1", f"POINTS {HUGE}") + "1 2 3\n", f"1 lines .*{HUGE}"),
        ("a.pcd", HEAD.replace("x y z", "a b c") + "1 2 3\n", r"'0a', '1b', '2c'.*\bx, y and z\b"),
        (
            "a.pcd",
            HEAD.replace("ascii", "morse") + "1 2 3\n",
            r"DATA\b.*'morse'.*\bascii, binary or binary_compressed\b",
        ),
        ("a.pcd", HEAD + "1 2\n", "2 columns"),
        ("a.pcd", HEAD + "1 2 three\n", "three"),
        ("a.pcd", "\x00\x01 nonsense", "header .*'DATA'"),
        ("a.ply", "ply\nformat ascii 1.0\nelement face 1\nend_header\n3 0 1 2\n", "'face'.*'vertex'"),
        ("a.ply", "plan\nformat ascii 1.0\nelement vertex 1\nend_header\n", r"first line\b.*'ply'"),
        ("a.xyz", "", "0 points"),
        ("a.xyz", "1 2\n", "2 columns"),
        ("a.obj", "v 1 2 3\n", r"'\.obj'.*'\.npy', '\.pcd', '\.ply', '\.xyz'"),
    ],
)
def test_what_is_no_cloud_is_a_cloud_error(tmp_path: Path, name: str, content: str, said: str) -> None:
    (tmp_path / name).write_text(content)
    with pytest.raises(CloudError, match=said):
        read_cloud(tmp_path / name)


def test_a_missing_file_and_an_odd_array_are_cloud_errors(tmp_path: Path) -> None:
    with pytest.raises(CloudError, match=r"missing\.pcd"):
        read_cloud(tmp_path / "missing.pcd")
    np.save(tmp_path / "odd.npy", np.zeros((4, 2)))
    with pytest.raises(CloudError, match=r"\(4, 2\)"):
        read_cloud(tmp_path / "odd.npy")
