"""The database: nearest neighbours, their votes, and what is refused."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from beltsort.errors import DatabaseError
from beltsort.perception import NearestNeighbour

from .databases import CLASSES, database


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


@pytest.mark.parametrize(
    ("rows", "labels", "said"),
    [
        (np.empty((0, 308)), [], "n > 0"),
        (np.ones((2, 307)), [0, 1], "307"),
        (np.ones((2, 308)), [0], r"\(1,\)"),
        (np.full((1, 308), np.nan), [0], r"descriptors .*\bfinite\b"),
        (-np.ones((1, 308)), [0], r"descriptors .*\bnegative\b"),
        (np.ones((1, 308)), [3], r"labels .*\b3\b.*\b0\b.*\b2\b"),
        (np.ones((1, 308)), [-1], r"labels .*-1\b.*\b0\b.*\b2\b"),
        (np.ones((1, 308)), ["a"], r"labels .*<U1\b"),
        (np.ones((1, 308)), [0.5], r"labels .*\bfloat64\b"),
        ("x", [0], r"descriptors\b.*'x'.*\bnumbers\b"),
        (np.ones((2, 308)), [[0], [0, 1]], r"labels\b.*inhomogeneous.*\bnumbers\b"),
        (np.ones((1, 308)), 0, r"labels\b.*\(1, 308\).* \(\).*\(n, 308\)"),
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
        (np.ones(307), r"descriptor .*\(307,\).*\(308,\)"),
        (np.float64(1.0), r"descriptor .*\(\).*\(308,\)"),
        (np.full(308, np.nan), r"descriptor .*\bnan\b.*\bbin 0\b"),
        (np.where(np.arange(308) == 7, -0.5, 1.0), r"descriptor .*-0\.5\b.*\bbin 7\b"),
        (["x"] * 308, r"descriptor\b.*'x'.*\bnumbers\b"),
    ],
)
def test_what_is_no_descriptor_is_refused(descriptor: Any, said: str) -> None:
    with pytest.raises(DatabaseError, match=said):
        database().match(descriptor)


def one_bin(values: list[float], labels: list[int], **settings: Any) -> NearestNeighbour:
    rows = np.zeros((len(values), 308))
    rows[:, 0] = values
    return NearestNeighbour.train(rows, labels, CLASSES, distance="l1", **settings)


QUERY = np.eye(1, 308)[0] * 10.0


def test_the_majority_of_the_k_nearest_wins() -> None:
    values, labels = [10.5, 11.0, 11.5, 20.0], [0, 1, 1, 2]
    match = one_bin(values, labels, k=3).match(QUERY)
    assert match.label == 1
    assert match.scores.tolist() == pytest.approx([1 / 3, 2 / 3, 0.0])
    assert match.distances is not None
    assert match.distances.tolist() == [0.5, 1.0, 10.0]
    assert (match.ranking, match.distance, match.runner_up) == ((1, 0, 2), 1.0, 0.5)
    assert one_bin(values, labels, k=1).match(QUERY).label == 0


def test_of_equally_many_votes_those_with_the_nearest_win() -> None:
    assert one_bin([11.0, 10.5, 10.7, 11.1], [1, 2, 1, 2], k=4).match(QUERY).label == 2
    assert one_bin([11.0, 10.5, 10.7], [0, 2, 1], k=3).match(QUERY).label == 2


def test_entries_equally_near_vote_in_their_order() -> None:
    assert one_bin([11.0, 9.0, 11.0], [1, 1, 0], k=2).match(QUERY).scores.tolist() == [0.0, 1.0, 0.0]


def test_without_ties_one_neighbour_is_the_nearest() -> None:
    trained = database()
    for query in database(seed=2).descriptors:
        match = replace(trained, k=1).match(query)
        assert match.distances is not None
        assert match.label == match.distances.argmin()


def test_a_cloud_like_nothing_known_gets_no_label() -> None:
    near, far = (one_bin([11.0, 15.0], [0, 1], reject=reject).match(QUERY) for reject in (1.0, 0.9))
    assert (near.label, near.distance) == (0, 1.0)
    assert (far.label, far.distance, far.ranking[0]) == (None, 1.0, 0)


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"distance": "cosine"}, r"\bdistance\b.*'cosine'.*'chi2', 'l1', 'l2'"),
        ({"distance": ["l1"]}, r"\bdistance\b.*\['l1'\].*'chi2', 'l1', 'l2'"),
        ({"k": 0}, r"\bk\b.*\b0\b.*\b1\b.*\b12\b"),
        ({"k": 13}, r"\bk\b.*\b13\b.*\b1\b.*\b12\b"),
        ({"k": 1.0}, r"\bk\b.*\b1\.0\b.*\b12\b"),
        ({"k": True}, r"\bk\b.*\bTrue\b.*\b12\b"),
        ({"reject": 0.0}, r"\breject\b.*\b0\.0\b.*\bNone\b"),
        ({"reject": np.nan}, r"\breject\b.*\bnan\b.*\bNone\b"),
        ({"reject": np.inf}, r"\breject\b.*\binf\b.*\bNone\b"),
        ({"classes": ("a", "b", "b")}, r"\bclasses\b.*\['a', 'b', 'b'\]"),
    ],
)
def test_settings_without_sense_are_refused(settings: dict[str, Any], said: str) -> None:
    with pytest.raises(DatabaseError, match=said):
        replace(database(), **settings)
