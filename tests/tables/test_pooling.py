"""A prior for tables of few objects: what all of their rows have in common."""

import numpy as np
import pytest

from beltsort import ArgumentError, SortingModel
from beltsort.tables import estimate
from beltsort.tables.counts import Counts
from beltsort.tables.intervals import credible_intervals
from beltsort.tables.pooling import pooled_prior
from beltsort.tables.scans import LabelledScan

CONFIDENT = (0, 0, 1, 1, None)  # "a, unsure", "a, sure", "b, unsure", "b, sure", "not recognised"


def counts_of(table: np.ndarray, label_classes: tuple[int | None, ...] | None = None) -> Counts:
    rows = table.shape[:3]
    empty = np.zeros(rows[:2], dtype=np.int64)
    return Counts(table, np.zeros(rows, dtype=np.int64), empty, empty, label_classes)


def drawn(seed: int, shape: tuple[int, int, int, int], most: int) -> Counts:
    return counts_of(np.random.default_rng(seed).integers(0, most, shape))


def accurate(accuracy: float, classes: int, viewpoints: int) -> np.ndarray:
    """Return a table, all of whose rows are right this often, shape (1, K, L, L)."""
    table = np.full((1, viewpoints, classes, classes), (1.0 - accuracy) / (classes - 1))
    table[..., np.arange(classes), np.arange(classes)] = accuracy
    return table


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("named", [None, CONFIDENT])
def test_pseudo_counts_are_positive_and_of_equal_weight_in_all_rows(
    named: tuple[int | None, ...] | None, seed: int
) -> None:
    labels = 2 if named is None else len(named)
    counts = counts_of(drawn(seed, (2, 2, 2, labels), 3).counts, named)
    prior = pooled_prior(counts)
    assert (prior > 0.0).all()
    np.testing.assert_allclose(prior.sum(axis=-1), prior[0, 0, 0].sum())
    assert prior[0, 0, 0].sum() <= counts.counts.sum() + 5  # what is known of all rows


def test_relabelling_classes_relabels_the_prior() -> None:
    counts, order = drawn(1, (1, 2, 4, 4), 5), np.array([2, 0, 3, 1])
    other = counts_of(counts.counts[:, :, order][..., order])
    np.testing.assert_allclose(pooled_prior(other), pooled_prior(counts)[:, :, order][..., order])


def test_many_objects_outweigh_the_prior() -> None:
    counts = counts_of(drawn(2, (1, 1, 3, 3), 9).counts * 10**6)
    np.testing.assert_allclose(
        counts.probabilities(pooled_prior(counts)), counts.probabilities(1.0), atol=1e-4
    )


def test_without_any_object_the_prior_is_uniform() -> None:
    prior = pooled_prior(counts_of(np.zeros((1, 1, 3, 3), dtype=np.int64)))
    np.testing.assert_allclose(prior / prior.sum(axis=-1, keepdims=True), 1.0 / 3.0, atol=0.17)


def test_a_row_without_objects_has_the_share_of_right_labels_of_all() -> None:
    table = np.zeros((1, 1, 3, 3), dtype=np.int64)
    table[0, 0, 0, 0], table[0, 0, 1, 1], table[0, 0, 1, 0] = 50, 40, 8
    counts = counts_of(table)
    row = counts.probabilities(pooled_prior(counts))[0, 0, 2]
    np.testing.assert_allclose(row, [9 / 200, 9 / 200, 91 / 100])


def test_levels_of_confidence_and_labels_without_a_class_are_pooled_apart() -> None:
    table = np.zeros((1, 1, 2, 5), dtype=np.int64)
    table[0, 0, 0] = [1, 8, 3, 0, 4]
    counts = counts_of(table, CONFIDENT)
    row = counts.probabilities(pooled_prior(counts))[0, 0, 1]
    np.testing.assert_allclose(row, np.array([4, 1, 2, 9, 5]) / 21)


def test_few_objects_of_many_classes_keep_their_accuracy() -> None:
    """Two objects a row and twelve classes, all right: a uniform prior believes 3 / 14."""
    counts = counts_of(np.tile(2 * np.eye(12, dtype=np.int64), (1, 3, 1, 1)))
    assert counts.probabilities(1.0)[0, 0, 0, 0] < 0.25
    assert counts.probabilities(pooled_prior(counts))[0, 0, 0, 0] > 0.95


def test_rows_that_differ_by_chance_alone_are_shrunk_more_than_rows_that_differ() -> None:
    generator = np.random.default_rng(3)
    alike = accurate(0.8, 4, 6)
    differing = np.concatenate([accurate(0.98, 4, 3), accurate(0.4, 4, 3)], axis=1)
    weights = [
        pooled_prior(counts_of(generator.multinomial(20, table)))[0, 0, 0].sum()
        for table in (alike, differing)
    ]
    assert weights[0] > 4.0 * weights[1]


@pytest.mark.parametrize("objects", [1, 2, 3, 10, 30])
def test_intervals_cover_the_truth(objects: int) -> None:
    """Rows of accuracy 0.7 to 0.99, from `objects` objects each: 95 % intervals, by simulation."""
    generator = np.random.default_rng(objects)
    covered = []
    for _ in range(20):
        truth = np.concatenate([accurate(p, 6, 1) for p in generator.uniform(0.7, 0.99, 6)], axis=1)
        counts = counts_of(generator.multinomial(objects, truth))
        lower, upper = credible_intervals(counts, pooled_prior(counts))
        covered.append((lower <= truth) & (truth <= upper))
    assert np.mean(covered) > 0.9


@pytest.mark.parametrize("objects", [1, 2, 3, 10, 30])
def test_predictions_are_better_than_with_a_uniform_prior(objects: int) -> None:
    """Kullback-Leibler divergence from the truth, mean over rows and draws of the paper's own table."""
    truth = SortingModel.load("tests/fixtures/paper.json").p_obs
    truth = (truth + 0.002) / (truth + 0.002).sum(axis=-1, keepdims=True)
    generator = np.random.default_rng(objects)
    divergence = np.zeros(2)
    for _ in range(20):
        counts = counts_of(generator.multinomial(objects, truth))
        tables = counts.probabilities(1.0), counts.probabilities(pooled_prior(counts))
        divergence += [(truth * np.log(truth / table)).sum(axis=-1).mean() for table in tables]
    assert divergence[1] < divergence[0]


def test_estimate_uses_it_unless_told_otherwise_and_the_model_keeps_it() -> None:
    scans = [LabelledScan(0, (i % 2,), (f"object {i}",), (i % 2,)) for i in range(4)]
    result = estimate(scans, ["nut", "bolt"], ["above"])
    prior = pooled_prior(result.counts)
    np.testing.assert_allclose(result.model.p_obs, result.counts.probabilities(prior))
    again = SortingModel.from_json(result.model.to_json())
    assert again == result.model
    assert again.smoothing is not None
    np.testing.assert_allclose(np.asarray(again.smoothing), prior)
    np.testing.assert_allclose(
        estimate(scans, ["nut", "bolt"], ["above"], smoothing=1.0).model.p_obs[0, 0, 0], [0.75, 0.25]
    )


@pytest.mark.parametrize("weight", [0.0, -1.0, np.inf, np.nan])
def test_a_senseless_weight_is_named(weight: float) -> None:
    with pytest.raises(ArgumentError, match=f"{weight}, expected a positive number"):
        pooled_prior(drawn(3, (1, 1, 2, 2), 3), weight)


def test_pseudo_counts_of_another_shape_are_refused() -> None:
    counts = drawn(3, (1, 1, 2, 2), 3)
    with pytest.raises(ArgumentError, match=r"smoothing has shape \(1, 1, 2, 1\), expected a number or an"):
        counts.probabilities(np.ones((1, 1, 2, 1)))
