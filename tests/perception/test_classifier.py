"""The database: chi-square nearest neighbour, and files that keep it or say why not."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from beltsort.errors import DatabaseError
from beltsort.perception import NearestNeighbour, PerceptionConfig

CLASSES = ["a", "b", "c"]


def database(seed: int = 0, n: int = 12) -> NearestNeighbour:
    rng = np.random.default_rng(seed)
    rows = rng.gamma(0.5, size=(n, 308)) * (rng.random((n, 308)) < 0.3)
    return NearestNeighbour.train(rows, np.arange(n) % 3, CLASSES, PerceptionConfig(voxel=0.004))


def test_chi_square_by_hand() -> None:
    rows = np.zeros((3, 308))
    rows[0, 0], rows[1, 0], rows[2, 1] = 1.0, 2.0, 4.0
    query = np.zeros(308)
    query[0] = 3.0
    match = NearestNeighbour.train(rows, [0, 1, 0], CLASSES).match(query)
    assert match.label == 1
    assert match.distance == pytest.approx(1.0 / 5.0)
    assert match.runner_up == pytest.approx(4.0 / 4.0)


def test_every_entry_finds_itself_and_relabelling_relabels() -> None:
    trained = database()
    renamed = NearestNeighbour.train(trained.descriptors, (trained.labels + 1) % 3, CLASSES)
    for row, label in zip(trained.descriptors, trained.labels, strict=True):
        assert trained.match(row).distance == 0.0
        assert trained.match(row).label == label
        assert renamed.match(row).label == (label + 1) % 3


def test_runner_up_is_the_nearest_of_another_class() -> None:
    trained = database()
    query = database(seed=1).descriptors[0]
    match = trained.match(query)
    total = np.maximum(trained.descriptors + query, 1e-300)
    distances = ((trained.descriptors - query) ** 2 / total).sum(axis=1)
    assert match.distance == pytest.approx(distances[trained.labels == match.label].min())
    assert match.runner_up == pytest.approx(distances[trained.labels != match.label].min())


def test_one_class_has_no_runner_up() -> None:
    alone = NearestNeighbour.train(np.ones((2, 308)), [0, 0], ["only"])
    assert alone.match(np.zeros(308)).runner_up == np.inf


def test_what_is_saved_is_loaded(tmp_path: Path) -> None:
    saved = database()
    saved.save(tmp_path / "bulbs.npz")
    loaded = NearestNeighbour.load(tmp_path / "bulbs.npz")
    assert np.array_equal(loaded.descriptors, saved.descriptors)
    assert np.array_equal(loaded.labels, saved.labels)
    assert (loaded.classes, loaded.config) == (saved.classes, saved.config)


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
    with pytest.raises(DatabaseError, match="cannot read"):
        NearestNeighbour.load(tmp_path / name)
    with pytest.raises(DatabaseError, match="cannot write"):
        database().save(tmp_path / "no" / "folder" / name)


@pytest.mark.parametrize(
    ("field", "value"),
    [("version", 3), ("classes", ["a"]), ("config", {"voxel": 1.0, "unknown": 2}), ("config", None)],
)
def test_a_header_that_does_not_fit_is_a_database_error(tmp_path: Path, field: str, value: object) -> None:
    path = tmp_path / "bulbs.npz"
    database().save(path)
    arrays: dict[str, Any] = dict(np.load(path))
    arrays["header"] = np.array(json.dumps({**json.loads(str(arrays["header"])), field: value}))
    np.savez(path, **arrays)
    with pytest.raises(DatabaseError, match="train again"):
        NearestNeighbour.load(path)


def test_pickled_objects_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "bulbs.npz"
    np.savez(path, descriptors=np.array([object()]), labels=np.array([0]), header=np.array("{}"))
    with pytest.raises(DatabaseError, match="object"):
        NearestNeighbour.load(path)


@pytest.mark.parametrize(
    ("rows", "labels", "said"),
    [
        (np.empty((0, 308)), [], "n > 0"),
        (np.ones((2, 307)), [0, 1], "307"),
        (np.ones((2, 308)), [0], r"\(1,\)"),
        (np.full((1, 308), np.nan), [0], "not finite"),
        (-np.ones((1, 308)), [0], "negative"),
        (np.ones((1, 308)), [3], "0 to 2"),
        (np.ones((1, 308)), [-1], "0 to 2"),
        (np.ones((1, 308)), ["a"], "class indices"),
        (np.ones((1, 308)), [0.5], "class indices"),
        ("x", [0], "descriptors: .* expected numbers"),
        (np.ones((2, 308)), [[0], [0, 1]], "labels: .* expected numbers"),
        (np.ones((1, 308)), 0, "one label for each descriptor"),
    ],
)
def test_what_is_no_database_is_refused(rows: Any, labels: Any, said: str) -> None:
    with pytest.raises(DatabaseError, match=said):
        NearestNeighbour.train(rows, labels, CLASSES)


def test_training_copies_the_descriptors() -> None:
    rows = np.ones((1, 308))
    trained = NearestNeighbour.train(rows, [0], CLASSES)
    rows[0, 0] = -1.0
    assert trained.descriptors[0, 0] == 1.0


def test_a_list_is_matched_like_an_array() -> None:
    query = database(seed=1).descriptors[0]
    assert database().match(query.tolist()).distance == database().match(query).distance


@pytest.mark.parametrize(
    ("descriptor", "said"),
    [
        (np.ones(307), r"shape \(307,\), expected \(308,\)"),
        (np.float64(1.0), r"shape \(\)"),
        (np.full(308, np.nan), "holds nan in bin 0"),
        (np.where(np.arange(308) == 7, -0.5, 1.0), "holds -0.5 in bin 7"),
        (["x"] * 308, "descriptor: .* expected numbers"),
    ],
)
def test_what_is_no_descriptor_is_refused(descriptor: Any, said: str) -> None:
    with pytest.raises(DatabaseError, match=said):
        database().match(descriptor)
