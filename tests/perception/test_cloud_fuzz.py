"""Any bytes are a cloud or a CloudError, and no header has memory allocated for what is not there."""

import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from beltsort.errors import CloudError
from beltsort.perception import read_cloud
from tests.laws import cases
from tests.perception.test_clouds import WRITERS

pytestmark = pytest.mark.filterwarnings("ignore::beltsort.perception.FileWarning")

PATCHES = st.tuples(st.floats(0.0, 1.0), st.binary(min_size=1, max_size=4))
SUFFIXES = (".pcd", ".ply", ".xyz", ".npy")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("whole")
    for name, write in WRITERS.items():
        write(made / name)
    return made


def read_or_refuse(path: Path, content: bytes) -> None:
    path.write_bytes(content)
    try:
        cloud = read_cloud(path)
    except CloudError:
        return
    assert cloud.dtype == np.float64
    assert cloud.shape == (len(cloud), 3)
    assert len(cloud) > 0


@cases(200)
@given(suffix=st.sampled_from(SUFFIXES), content=st.binary(max_size=300))
def test_random_bytes(folder: Path, suffix: str, content: bytes) -> None:
    read_or_refuse(folder / f"random{suffix}", content)


@cases(300)
@given(
    name=st.sampled_from(sorted(WRITERS)),
    changes=st.lists(
        st.tuples(st.floats(0.0, 1.0), st.binary(min_size=1, max_size=4)), min_size=1, max_size=6
    ),
    in_header=st.booleans(),
)
def test_mutated_files(folder: Path, name: str, changes: list[tuple[float, bytes]], in_header: bool) -> None:
    content = bytearray((folder / name).read_bytes())
    reach = min(200, len(content)) if in_header else len(content)
    for share, patch in changes:
        at = int(share * (reach - 1))
        content[at : at + len(patch)] = patch
    read_or_refuse(folder / f"mutated-{name}", bytes(content))


@cases(150)
@given(name=st.sampled_from(sorted(WRITERS)), share=st.floats(0.0, 1.0))
def test_truncated_files(folder: Path, name: str, share: float) -> None:
    content = (folder / name).read_bytes()
    read_or_refuse(folder / f"truncated-{name}", content[: int(share * len(content))])


@cases(150)
@given(
    name=st.sampled_from(["text.pcd", "binary.pcd", "compressed.pcd", "text.ply", "binary.ply"]),
    number=st.sampled_from([b"0", b"-1", b"49", b"51", b"1e3", b"4294967296", b"9" * 30, b"x", b""]),
    which=st.integers(0, 30),
)
def test_headers_with_another_number(folder: Path, name: str, number: bytes, which: int) -> None:
    words = (folder / name).read_bytes().split(b" ")
    numeric = [i for i, word in enumerate(words[:60]) if word[:1].isdigit()]
    at = numeric[which % len(numeric)]
    rest = words[at].lstrip(b"0123456789.")
    words[at] = number + rest
    read_or_refuse(folder / f"header-{name}", b" ".join(words))


HUGE = 10**12


def npy_header(shape: tuple[int, ...]) -> bytes:
    text = f"{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}}}"
    return b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text.encode()


PCD = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nPOINTS {count}\nDATA {encoding}\n"


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("a.pcd", PCD.format(count=HUGE, encoding="binary").encode() + bytes(24)),
        ("a.pcd", PCD.format(count=HUGE, encoding="ascii").encode() + b"1 2 3\n"),
        ("a.pcd", PCD.format(count=HUGE, encoding="binary_compressed").encode() + bytes(24)),
        (
            "a.pcd",
            PCD.format(count=2**28, encoding="binary_compressed").encode()
            + (4).to_bytes(4, "little")
            + (12 * 2**28 % 2**32).to_bytes(4, "little")
            + bytes(4),
        ),
        ("a.ply", f"ply\nformat ascii 1.0\nelement vertex {HUGE}\nend_header\n".encode()),
        ("a.npy", npy_header((HUGE, 3)) + bytes(24)),
        ("a.npy", npy_header((-1, 3)) + bytes(24)),
    ],
)
def test_no_memory_for_empty_promises(tmp_path: Path, name: str, content: bytes) -> None:
    (tmp_path / name).write_bytes(content)
    tracemalloc.start()
    try:
        with pytest.raises(CloudError, match=name):
            read_cloud(tmp_path / name)
        assert tracemalloc.get_traced_memory()[1] < 2**20
    finally:
        tracemalloc.stop()


def test_blank_lines_are_no_points(tmp_path: Path) -> None:
    (tmp_path / "a.pcd").write_text(PCD.format(count=3, encoding="ascii") + "1 2 3\n\n4 5 6\n")
    with pytest.raises(CloudError, match=r"a\.pcd\b.*\b2 lines\b.*\b3\b"):
        read_cloud(tmp_path / "a.pcd")
