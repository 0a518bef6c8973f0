"""Leaving one out: as if the entry had never been there."""

from dataclasses import replace

import numpy as np
import pytest

from beltsort.errors import DatabaseError
from beltsort.perception import NearestNeighbour, confusion, leave_one_out, rejection_threshold
from beltsort.perception.leave_one_out import suspects, training_distance, with_rejection

from .databases import CLASSES, database


@pytest.mark.parametrize("distance", ["chi2", "l1", "l2"])
@pytest.mark.parametrize("k", [1, 3])
def test_every_answer_is_that_of_a_database_without_the_entry(distance: str, k: int) -> None:
    trained = database(n=15, distance=distance, k=k)
    for i, match in enumerate(leave_one_out(trained)):
        others = np.arange(15) != i
        without = replace(trained, descriptors=trained.descriptors[others], labels=trained.labels[others])
        expected = without.match(trained.descriptors[i])
        assert match.label == expected.label
        np.testing.assert_array_equal(match.scores, expected.scores)
        assert match.distances is not None
        assert match.distances.tolist() == pytest.approx(expected.distances)


def test_all_others_vote_if_fewer_than_k_are_left() -> None:
    trained = NearestNeighbour.train(np.eye(3, 308), [0, 1, 1], CLASSES, k=3)
    scores = [match.scores.tolist() for match in leave_one_out(trained)]
    assert scores == [[0.0, 1.0, 0.0], [0.5, 0.5, 0.0], [0.5, 0.5, 0.0]]


def test_one_entry_cannot_be_left_out() -> None:
    with pytest.raises(DatabaseError, match=r"\b1 entry\b.*\b2\b"):
        leave_one_out(NearestNeighbour.train(np.ones((1, 308)), [0], CLASSES))


def line(places: list[float], labels: list[int]) -> NearestNeighbour:
    rows = np.zeros((len(places), 308))
    rows[:, 0] = places
    return NearestNeighbour.train(rows, labels, CLASSES, distance="l1")


def test_the_threshold_is_a_distance_that_so_many_of_a_class_keep() -> None:
    places = np.cumsum(np.arange(101.0))  # neighbours 1, 2, ..., 100 apart
    trained = line(places.tolist(), [0] * 101)
    left_out = leave_one_out(trained)
    assert rejection_threshold(trained, left_out) == 99.0
    assert rejection_threshold(trained, left_out, 100.0) == 100.0
    assert rejection_threshold(trained, left_out, 50.0) == 50.0


def test_the_threshold_rejects_no_known_entry_of_a_small_database() -> None:
    trained = line([0.0, 1.0, 10.0, 13.0, 17.0, 50.0, 51.0], [0, 0, 1, 1, 1, 2, 2])
    left_out = leave_one_out(trained)
    threshold = rejection_threshold(trained, left_out)
    assert threshold == 4.0
    rejecting, answers = with_rejection(trained, left_out, threshold)
    assert [match.label for match in answers] == trained.labels.tolist()
    far = np.zeros(308)
    far[0] = 30.0
    assert rejecting.match(far).label is None
    assert trained.match(far).label is not None


def test_without_two_different_entries_of_a_class_there_is_no_threshold() -> None:
    for trained in (line([0.0, 1.0], [0, 1]), line([1.0, 1.0, 3.0], [0, 0, 1])):
        assert rejection_threshold(trained, leave_one_out(trained)) is None


def test_rejection_afterwards_is_rejection_from_the_start() -> None:
    trained = database(n=15, k=3)
    reject = float(np.median([match.distance or 0.0 for match in leave_one_out(trained)]))
    rejecting, answers = with_rejection(trained, leave_one_out(trained), reject)
    labels = [match.label for match in answers]
    assert labels == [match.label for match in leave_one_out(rejecting)]
    assert None in labels


def test_confusion_counts_every_answer_once() -> None:
    trained = database(n=30)
    reject = float(np.median([match.distance or 0.0 for match in leave_one_out(trained)]))
    trained, answers = with_rejection(trained, leave_one_out(trained), reject)
    table = confusion(trained.labels, answers, trained.classes)
    assert table.total == 30
    np.testing.assert_array_equal(table.counts.sum(axis=1), np.bincount(trained.labels))
    assert table.counts[:, -1].sum() == sum(match.label is None for match in answers) > 0
    assert table.right == sum(m.label == t for m, t in zip(answers, trained.labels, strict=True))


def test_a_class_without_answers_has_no_recall() -> None:
    table = confusion([0, 0], leave_one_out(line([0.0, 1.0], [0, 0])), CLASSES)
    np.testing.assert_array_equal(table.recall, [1.0, np.nan, np.nan])


def test_entries_nearer_to_another_class_are_suspects() -> None:
    trained = line([0.0, 1.0, 1.5, 10.0, 11.0, 0.5, 4.0], [0, 0, 0, 1, 1, 1, 0])
    found = suspects(trained, leave_one_out(trained))
    assert found[0].entry == 5  # of class 1 amid class 0
    assert (found[0].other, found[0].distance < found[0].own_distance) == (0, True)
    ratios = [suspect.distance / suspect.own_distance for suspect in found]
    assert ratios == sorted(ratios)
    for suspect in found:
        assert suspect.other != trained.labels[suspect.entry]


def test_the_only_entry_of_a_class_is_no_suspect() -> None:
    trained = line([0.0, 1.0, 0.4], [0, 0, 1])
    assert 2 not in [suspect.entry for suspect in suspects(trained, leave_one_out(trained))]


def test_a_mislabelled_entry_does_not_count_for_the_training_distance() -> None:
    trained = line([0.0, 1.0, 2.0, 50.0, 51.0, 52.0, 1.5], [0, 0, 0, 1, 1, 1, 1])
    left_out = leave_one_out(trained)
    without = line([0.0, 1.0, 2.0, 50.0, 51.0, 52.0], [0, 0, 0, 1, 1, 1])
    suggested = rejection_threshold(trained, left_out)
    expected = training_distance(without, leave_one_out(without))
    assert suggested is not None
    assert expected is not None
    assert training_distance(trained, left_out) == pytest.approx(expected)
    assert suggested > 10.0 * expected
    kept, _ = with_rejection(trained, left_out, None)
    assert kept.training_distance == training_distance(trained, left_out)
