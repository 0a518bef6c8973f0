"""Kernel ridge regression on the entries of a database."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from beltsort.errors import DatabaseError
from beltsort.geometry import BeltLayout
from beltsort.perception import (
    KernelRidge,
    NearestNeighbour,
    Perception,
    PerceptionConfig,
    leave_one_out,
    load_classifier,
    load_trained,
)
from beltsort.perception.kernel_ridge import RIDGE, WIDTH
from beltsort.tables.confidence import fit_levels
from beltsort.tables.matches import MatchedScan, Seen

from .databases import database


def clustered(seed: int = 0, n: int = 60) -> NearestNeighbour:
    """Return a database of three classes that overlap."""
    rng = np.random.default_rng(seed)
    labels = np.arange(n) % 3
    rows = rng.poisson(1.0 + 2.0 * np.eye(3, 308)[labels][:, rng.integers(6, size=308) % 308])
    return NearestNeighbour.train(rows, labels, ["a", "b", "c"])


def by_definition(trained: NearestNeighbour, queries: Any, scale: float | None = None) -> Any:
    """Return the scores of the equations, written out; the default scale is that of the entries."""
    rows = trained.descriptors

    def distances(a: Any) -> Any:
        total = a + rows
        return (np.square(a - rows) / np.where(total > 0.0, total, 1.0)).sum(axis=1)

    between = np.stack([distances(row) for row in rows])
    scale = scale or WIDTH * np.median(between[np.triu_indices(len(rows), 1)])
    targets = np.where(trained.labels[:, None] == np.arange(len(trained.classes)), 1.0, -1.0)
    solved = np.linalg.solve(np.exp(-between / scale) + RIDGE * np.eye(len(rows)), targets)
    return np.stack([np.exp(-distances(query) / scale) @ solved for query in queries])


def test_scores_are_those_of_the_equations() -> None:
    trained, queries = clustered(), clustered(1, 9).descriptors
    classifier = KernelRidge.train(trained)
    expected = np.exp(classifier.sharpness * by_definition(trained, queries))
    expected /= expected.sum(axis=1, keepdims=True)
    for query, probabilities in zip(queries, expected, strict=True):
        match = classifier.match(query)
        assert match.probabilities is not None
        np.testing.assert_allclose(match.probabilities, probabilities, rtol=1e-7)
        assert match.label == probabilities.argmax()
        assert match.distances is not None
        np.testing.assert_array_equal(match.distances, trained.match(query).distances)


def test_left_out_scores_are_those_of_fits_without_the_entry() -> None:
    trained = clustered()
    classifier = KernelRidge.train(trained)
    left_out = leave_one_out(classifier)
    for entry in range(0, 60, 7):
        kept = np.arange(60) != entry
        rest = replace(trained, descriptors=trained.descriptors[kept], labels=trained.labels[kept])
        scores = by_definition(rest, trained.descriptors[entry : entry + 1], classifier.scale)[0]
        expected = np.exp(classifier.sharpness * scores)
        match = left_out[entry]
        assert match.probabilities is not None
        np.testing.assert_allclose(match.probabilities, expected / expected.sum(), rtol=1e-7)
        assert match.distance is not None
        assert match.distance > 0.0


def test_renaming_classes_renames_labels() -> None:
    trained = clustered()
    order = np.array([2, 0, 1])
    renamed = replace(
        trained, labels=np.argsort(order)[trained.labels], classes=tuple(trained.classes[i] for i in order)
    )
    one, other = KernelRidge.train(trained), KernelRidge.train(renamed)
    for query in clustered(1, 9).descriptors:
        a, b = one.match(query).probabilities, other.match(query).probabilities
        assert a is not None
        assert b is not None
        np.testing.assert_allclose(a[order], b, atol=1e-3)  # the sharpness is found within 1e-5


def test_what_is_farther_than_the_threshold_gets_no_label() -> None:
    trained = replace(clustered(), reject=1e-6, training_distance=1e-6)
    classifier = KernelRidge.train(trained)
    far = classifier.match(clustered(1).descriptors[0])
    assert far.label is None
    assert classifier.beyond_training(far)
    assert classifier.match(trained.descriptors[0]).label is not None


def test_identical_entries_are_no_error() -> None:
    trained = NearestNeighbour.train(np.ones((4, 308)), [0, 1, 0, 1], ["a", "b"])
    match = KernelRidge.train(trained).match(np.ones(308))
    assert match.probabilities is not None
    np.testing.assert_allclose(match.probabilities, [0.5, 0.5])


def test_what_is_saved_is_loaded(tmp_path: Path) -> None:
    path = tmp_path / "kernel.npz"
    saved = KernelRidge.train(replace(clustered(), reject=50.0, distance="l1"))
    saved.save(path)
    for loaded in (KernelRidge.load(path), load_trained(path), load_classifier(str(path))):
        assert isinstance(loaded, KernelRidge)
        assert np.array_equal(loaded.coefficients, saved.coefficients)
        assert (loaded.scale, loaded.sharpness) == (saved.scale, saved.sharpness)
        assert (loaded.database.distance, loaded.database.reject) == ("l1", 50.0)
        assert (loaded.classes, loaded.config) == (saved.classes, saved.config)


def test_a_file_of_the_other_kind_is_refused(tmp_path: Path) -> None:
    database().save(tmp_path / "nearest.npz")
    KernelRidge.train(clustered()).save(tmp_path / "kernel.npz")
    with pytest.raises(DatabaseError, match="holds a nearest-neighbour"):
        KernelRidge.load(tmp_path / "nearest.npz")
    with pytest.raises(DatabaseError, match="holds a kernel ridge"):
        NearestNeighbour.load(tmp_path / "kernel.npz")
    assert isinstance(load_trained(tmp_path / "nearest.npz"), NearestNeighbour)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"coefficients": np.zeros((3, 3))}, r"\(3, 3\).*\(60, 3\)"),
        ({"coefficients": np.full((60, 3), np.nan)}, "finite"),
        ({"scale": -1.0}, "scale is -1.0"),
        ({"sharpness": "high"}, "sharpness is 'high'"),
    ],
)
def test_what_does_not_fit_is_refused(changes: dict[str, Any], said: str) -> None:
    with pytest.raises(DatabaseError, match=said):
        replace(KernelRidge.train(clustered()), **changes)


def test_one_entry_is_too_few() -> None:
    with pytest.raises(DatabaseError, match="1 entries"):
        KernelRidge.train(NearestNeighbour.train(np.ones((1, 308)), [0], ["a"]))


def test_perception_takes_its_configuration() -> None:
    classifier = KernelRidge.train(database())
    assert Perception(BeltLayout(), classifier).config == database().config
    with pytest.raises(DatabaseError, match="voxel"):
        Perception(BeltLayout(), classifier, PerceptionConfig(voxel=0.01))


def test_levels_of_confidence_are_of_probabilities() -> None:
    classifier = KernelRidge.train(clustered())
    known = zip(classifier.labels.tolist(), leave_one_out(classifier), strict=True)
    scans = [MatchedScan(0, (true,), (f"{n}",), (Seen(match),)) for n, (true, match) in enumerate(known)]
    assert fit_levels(classifier, scans, 1, levels=2).rule.score == "probability"
