"""The database's file: what it keeps, and that nothing damaged or hostile passes."""

import json
import tracemalloc
from contextlib import suppress
from pathlib import Path
from typing import Any
from zipfile import ZIP_BZIP2, ZIP_DEFLATED, ZipFile

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from beltsort.errors import DatabaseError
from beltsort.perception import NearestNeighbour
from beltsort.perception.database import MOST_ENTRIES
from beltsort.perception.descriptor import LONGEST
from tests.laws import cases

from .databases import database


def test_what_is_saved_is_loaded(tmp_path: Path) -> None:
    saved = database(distance="l2", k=3, reject=2.5, training_distance=1.5)
    saved.save(tmp_path / "bulbs.npz")
    loaded = NearestNeighbour.load(tmp_path / "bulbs.npz")
    assert np.array_equal(loaded.descriptors, saved.descriptors)
    assert np.array_equal(loaded.labels, saved.labels)
    assert (loaded.classes, loaded.config) == (saved.classes, saved.config)
    assert (loaded.distance, loaded.k, loaded.reject) == ("l2", 3, 2.5)
    assert loaded.training_distance == 1.5


def changed_header(path: Path, **changes: object) -> None:
    """Rewrite the database at `path`; a field that becomes `...` is left out."""
    arrays: dict[str, Any] = dict(np.load(path))
    header = {**json.loads(str(arrays["header"])), **changes}
    kept = {name: value for name, value in header.items() if value is not ...}
    np.savez(path, **{**arrays, "header": np.array(json.dumps(kept))})


def test_version_1_is_read_with_the_settings_that_it_had(tmp_path: Path) -> None:
    path = tmp_path / "old.npz"
    database(distance="l2", k=3, reject=2.5).save(path)
    changed_header(path, version=1, distance=..., k=..., reject=...)
    loaded = NearestNeighbour.load(path)
    assert (loaded.distance, loaded.k, loaded.reject) == ("chi2", 1, None)
    assert np.array_equal(loaded.descriptors, database().descriptors)


def test_a_file_without_a_training_distance_is_read(tmp_path: Path) -> None:
    path = tmp_path / "old.npz"
    database(training_distance=1.5).save(path)
    changed_header(path, training_distance=...)
    loaded = NearestNeighbour.load(path)
    assert loaded.training_distance is None
    assert not loaded.beyond_training(loaded.match(np.full(308, 50.0)))


def test_what_is_unlike_all_entries_is_beyond_the_training_distance() -> None:
    trained = database(training_distance=1e-3)
    assert not trained.beyond_training(trained.match(trained.descriptors[0]))
    far = trained.match(np.full(308, 50.0))
    assert far.label is not None
    assert trained.beyond_training(far)
    with pytest.raises(DatabaseError, match="training_distance"):
        database(training_distance=-1.0)


@pytest.mark.parametrize("share", [0.0, 0.02, 0.5, 0.99])
def test_a_truncated_file_is_a_database_error(tmp_path: Path, share: float) -> None:
    path = tmp_path / "bulbs.npz"
    database().save(path)
    content = path.read_bytes()
    path.write_bytes(content[: int(share * len(content))])
    with pytest.raises(DatabaseError, match=r"bulbs\.npz"):
        NearestNeighbour.load(path)


def test_a_flipped_byte_in_the_descriptors_is_a_database_error(tmp_path: Path) -> None:
    path = tmp_path / "bulbs.npz"
    database().save(path)
    content = bytearray(path.read_bytes())
    for at in range(200, 1200, 100):
        damaged = bytearray(content)
        damaged[at] ^= 0xFF
        path.write_bytes(damaged)
        with pytest.raises(DatabaseError):
            NearestNeighbour.load(path)


@pytest.mark.parametrize("name", ["missing.npz", "."])
def test_no_file_is_a_database_error(tmp_path: Path, name: str) -> None:
    with pytest.raises(DatabaseError, match=r"/missing\.npz\b.*No such file|Is a directory"):
        NearestNeighbour.load(tmp_path / name)
    with pytest.raises(DatabaseError, match=r"/no/folder.*No such file"):
        database().save(tmp_path / "no" / "folder" / name)


@pytest.mark.parametrize(
    ("field", "value", "said"),
    [
        ("version", 4, r"\bversion\b.*\b4\b.*\(1, 2, 3\)"),
        ("version", ..., "'version'"),
        ("classes", ["a"], r"labels\b.*\b2\b.*\['a'\]"),
        ("classes", ["a", "b", "b"], r"classes\b.*'a', 'b', 'b'"),
        ("classes", ["a", 1, "b"], r"classes\b.*'a', 1, 'b'"),
        ("classes", None, "'NoneType'"),
        ("config", {"voxel": 1.0, "unknown": 2}, "'unknown'"),
        ("config", {"voxel": -1.0}, r"\bvoxel\b.*-1\.0\b"),
        ("config", None, r"PerceptionConfig\b.*\bNoneType\b"),
        ("distance", "cosine", r"\bdistance\b.*'cosine'.*'chi2', 'l1', 'l2'"),
        ("k", 1000, r"\bk\b.*\b1000\b.*\b12\b"),
        ("reject", -1.0, r"\breject\b.*-1\.0\b"),
        ("reject", "far", "'float'.*'str'"),
    ],
)
def test_a_header_that_does_not_fit_is_a_database_error(
    tmp_path: Path, field: str, value: object, said: str
) -> None:
    path = tmp_path / "bulbs.npz"
    database().save(path)
    changed_header(path, **{field: value})
    with pytest.raises(DatabaseError, match=rf"bulbs\.npz\b.*{said}"):
        NearestNeighbour.load(path)


def test_pickled_objects_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "bulbs.npz"
    database().save(path)
    np.savez(path, **{**np.load(path), "descriptors": np.array([object()])})
    with pytest.raises(DatabaseError, match=r"bulbs\.npz\b.*descriptors\b.*\bobject\b.*'f8'"):
        NearestNeighbour.load(path)


def npy(header: str, values: bytes) -> bytes:
    text = header.encode().ljust(117) + b"\n"
    return b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text + values


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("databases") / "hostile.npz"


def write_parts(path: Path) -> None:
    """Write a database without its descriptors."""
    database().save(path)
    arrays = dict(np.load(path))
    np.savez(path, labels=arrays["labels"], header=arrays["header"])


def with_descriptors(path: Path, member: bytes, method: int = ZIP_DEFLATED) -> None:
    write_parts(path)
    with ZipFile(path, "a", method) as archive:
        archive.writestr("descriptors.npy", member)


def refused_within(path: Path, most: int) -> str:
    """Return what is said, provided that no more than `most` bytes are allocated for it."""
    tracemalloc.start()
    try:
        with pytest.raises(DatabaseError) as raised:
            NearestNeighbour.load(path)
        assert tracemalloc.get_traced_memory()[1] < most
    finally:
        tracemalloc.stop()
    return str(raised.value)


def test_a_huge_declared_shape_allocates_nothing(path: Path) -> None:
    shape = "{'descr': '<f8', 'fortran_order': False, 'shape': (100000000, 308)}"
    with_descriptors(path, npy(shape, bytes(8 * 308)))
    assert "reshape" in refused_within(path, 2**20)


def test_a_bomb_is_not_unpacked(path: Path) -> None:
    shape = f"{{'descr': '<f8', 'fortran_order': False, 'shape': ({MOST_ENTRIES + 1000}, {LONGEST})}}"
    write_parts(path)
    with ZipFile(path, "a", ZIP_DEFLATED) as archive, archive.open("descriptors.npy", "w") as packed:
        packed.write(npy(shape, b""))
        for _ in range(MOST_ENTRIES // 1000 + 1):
            packed.write(bytes(8 * LONGEST * 1000))
    assert path.stat().st_size < 2**20
    assert str(MOST_ENTRIES * 8 * LONGEST) in refused_within(path, 2**20)


def test_a_size_that_the_archive_lies_about_is_a_database_error(path: Path) -> None:
    database().save(path)
    content = bytearray(path.read_bytes())
    entry = content.index(b"PK\x01\x02")  # of the central directory
    content[entry + 24 : entry + 28] = (1000).to_bytes(4, "little")
    path.write_bytes(content)
    assert "'descriptors.npy'" in refused_within(path, 2**20)


@pytest.mark.parametrize(
    ("member", "said"),
    [
        (b"", "magic|EOF"),
        (b"\x93NUMPY\x03\x00" + bytes(100), r"format \(3, 0\)"),
        (npy("{'descr': '|O', 'fortran_order': False, 'shape': (12, 308)}", bytes(64)), "pickled"),
        (npy("{'descr': '<i8', 'fortran_order': False, 'shape': (12, 308)}", bytes(64)), "int64"),
        (npy("{'descr': '<f8', 'fortran_order': False, 'shape': (-1, 308)}", bytes(64)), "reshape"),
        (npy("{'descr': '<f8', 'fortran_order': False, 'shape': (2, 308)}", bytes(64)), "reshape"),
        (npy("[" * 90, b""), "EOF"),
        (npy("{'descr': '<f2', 'fortran_order': False, 'shape': (12, 308)}", bytes(64)), "float16"),
    ],
)
def test_what_is_no_array_of_descriptors_is_a_database_error(path: Path, member: bytes, said: str) -> None:
    with_descriptors(path, member)
    with pytest.raises(DatabaseError, match=said):
        NearestNeighbour.load(path)


def test_a_rare_packing_is_refused(path: Path) -> None:
    with_descriptors(path, b"", ZIP_BZIP2)
    with pytest.raises(DatabaseError, match=r"descriptors\b.*\bmethod 12\b"):
        NearestNeighbour.load(path)


def load_or_refuse(path: Path) -> None:
    with suppress(DatabaseError):
        loaded = NearestNeighbour.load(path)
        assert loaded.match(database(seed=1).descriptors[0]).scores.sum() == pytest.approx(1.0)


@cases(100)
@given(st.binary(max_size=400))
def test_random_bytes_are_refused(path: Path, content: bytes) -> None:
    path.write_bytes(content)
    with pytest.raises(DatabaseError):
        NearestNeighbour.load(path)


@cases(100)
@given(
    st.lists(st.tuples(st.integers(0, 10**6), st.integers(0, 255)), min_size=1, max_size=8),
    st.floats(0.0, 1.0),
    st.booleans(),
)
def test_mutated_files_are_loaded_or_refused(
    path: Path, changes: list[tuple[int, int]], kept: float, packed: bool
) -> None:
    database(n=3).save(path)
    if not packed:
        np.savez(path, **np.load(path))
    content = bytearray(path.read_bytes())
    for at, value in changes:
        content[at % len(content)] = value
    path.write_bytes(content[: len(content) - int((1.0 - kept) ** 4 * len(content))])
    load_or_refuse(path)


@cases(100)
@given(
    st.dictionaries(
        st.sampled_from(["version", "classes", "config", "distance", "k", "reject"]),
        st.recursive(
            st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=4),
            lambda inner: (
                st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=4), inner, max_size=3)
            ),
        ),
        min_size=1,
    )
)
def test_headers_of_any_json_are_loaded_or_refused(path: Path, changes: dict[str, Any]) -> None:
    database(n=3).save(path)
    changed_header(path, **changes)
    load_or_refuse(path)


@cases(100)
@given(
    st.sampled_from(["descriptors.npy", "labels.npy", "header.npy"]),
    st.lists(st.tuples(st.integers(0, 200), st.integers(0, 255)), min_size=1, max_size=4),
    st.integers(0, 3),
)
def test_mutated_members_with_a_right_checksum_are_loaded_or_refused(
    path: Path, name: str, changes: list[tuple[int, int]], cut: int
) -> None:
    database(n=3).save(path)
    with ZipFile(path) as archive:
        members = {entry: bytearray(archive.read(entry)) for entry in archive.namelist()}
    for at, value in changes:
        members[name][at % len(members[name])] = value
    del members[name][len(members[name]) - cut :]
    with ZipFile(path, "w") as archive:
        for entry, content in members.items():
            archive.writestr(entry, bytes(content))
    load_or_refuse(path)
