"""Tables of few objects shrunk towards what all rows have in common."""

import numpy as np
import pytest

from beltsort import ArgumentError
from beltsort.tables.counts import Counts
from beltsort.tables.pooling import pooled_probabilities


def counts_of(table: np.ndarray) -> Counts:
    rows = table.shape[:3]
    empty = np.zeros(rows[:2], dtype=np.int64)
    return Counts(table, np.zeros(rows, dtype=np.int64), empty, empty)


def drawn(seed: int, shape: tuple[int, int, int, int], most: int) -> Counts:
    return counts_of(np.random.default_rng(seed).integers(0, most, shape))


@pytest.mark.parametrize("named", [None, [0, 0, 1, 1, 2, 2, None]])
def test_rows_are_positive_and_sum_to_one(named: list[int | None] | None) -> None:
    counts = drawn(0, (2, 2, 3, 3 if named is None else 7), 3)
    table = pooled_probabilities(counts, named)
    assert (table > 0.0).all()
    np.testing.assert_allclose(table.sum(axis=-1), 1.0)


def test_relabelling_classes_relabels_the_table() -> None:
    counts, order = drawn(1, (1, 2, 4, 4), 5), np.array([2, 0, 3, 1])
    other = counts_of(counts.counts[:, :, order][..., order])
    np.testing.assert_allclose(
        pooled_probabilities(other), pooled_probabilities(counts)[:, :, order][..., order]
    )


def test_many_objects_outweigh_the_prior() -> None:
    counts = counts_of(drawn(2, (1, 1, 3, 3), 9).counts * 10**6)
    np.testing.assert_allclose(pooled_probabilities(counts), counts.probabilities(1.0), atol=1e-4)


def test_a_row_without_objects_has_the_share_of_right_labels_of_all() -> None:
    table = np.zeros((1, 1, 3, 3), dtype=np.int64)
    table[0, 0, 0, 0], table[0, 0, 1, 1], table[0, 0, 1, 0] = 50, 40, 8
    row = pooled_probabilities(counts_of(table))[0, 0, 2]
    np.testing.assert_allclose(row, [9 / 200, 9 / 200, 91 / 100])


def test_levels_of_confidence_and_labels_without_a_class_are_pooled_apart() -> None:
    table = np.zeros((1, 1, 2, 5), dtype=np.int64)
    table[0, 0, 0] = [1, 8, 3, 0, 4]  # "a, unsure", "a, sure", "b, unsure", "b, sure", "not recognised"
    row = pooled_probabilities(counts_of(table), [0, 0, 1, 1, None])[0, 0, 1]
    np.testing.assert_allclose(row, np.array([4, 1, 2, 9, 5]) / 21)


def test_few_objects_of_many_classes_keep_their_accuracy() -> None:
    """Two objects a row and twelve classes, all right: a uniform prior believes 3 / 14."""
    counts = counts_of(np.tile(2 * np.eye(12, dtype=np.int64), (1, 3, 1, 1)))
    assert counts.probabilities(1.0)[0, 0, 0, 0] < 0.25
    assert pooled_probabilities(counts)[0, 0, 0, 0] > 0.95


def test_senseless_arguments_are_named() -> None:
    counts = drawn(3, (1, 1, 2, 2), 3)
    with pytest.raises(ArgumentError, match="pseudo_looks is 0"):
        pooled_probabilities(counts, pseudo_looks=0.0)
    with pytest.raises(ArgumentError, match="label_classes has 3 entries, expected 2"):
        pooled_probabilities(counts, [0, 1, None])
