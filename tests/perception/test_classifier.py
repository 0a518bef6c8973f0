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
        ({"distance": "cosine"}, "distance is 'cosine', expected one of .*chi2"),
        ({"distance": ["l1"]}, "distance is .*'l1'.*expected one of"),
        ({"k": 0}, "k is 0, expected an integer from 1 to 12"),
        ({"k": 13}, "k is 13, expected an integer from 1 to 12"),
        ({"k": 1.0}, "k is 1.0, expected an integer"),
        ({"k": True}, "k is True, expected an integer"),
        ({"reject": 0.0}, "reject is 0.0, expected a finite distance above 0"),
        ({"reject": np.nan}, "reject is nan"),
        ({"reject": np.inf}, "reject is inf"),
        ({"classes": ("a", "b", "b")}, "none twice"),
    ],
)
def test_settings_without_sense_are_refused(settings: dict[str, Any], said: str) -> None:
    with pytest.raises(DatabaseError, match=said):
        replace(database(), **settings)
