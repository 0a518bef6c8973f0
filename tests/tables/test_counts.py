"""Counts of labels that are more than the classes."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import beltsort
from beltsort.tables import Counts, Look, count

LOOKS = st.lists(
    st.builds(
        Look,
        position=st.integers(0, 1),
        viewpoint=st.integers(0, 1),
        true=st.integers(0, 2),
        observed=st.none() | st.integers(0, 2),
        again=st.none() | st.integers(0, 2),
    ),
    max_size=40,
)
LEVELS = (0, 0, 1, 1, 2, 2, None)


def same(one: Counts, other: Counts) -> bool:
    names = ("counts", "missed", "agree", "pairs")
    return all(np.array_equal(getattr(one, name), getattr(other, name)) for name in names)


@given(LOOKS)
def test_labels_that_are_the_classes_are_counted_as_ever(looks: list[Look]) -> None:
    plain, named = count(looks, 2, 2, 3), count(looks, 2, 2, 3, (0, 1, 2))
    assert same(plain, named)
    assert plain.probabilities(0.7).tobytes() == named.probabilities(0.7).tobytes()
    np.testing.assert_array_equal(plain.accuracy(), named.accuracy())


@given(LOOKS)
def test_levels_divide_the_counts_of_the_classes(looks: list[Look]) -> None:
    rng = np.random.default_rng(0)
    divided = [
        replace(look, observed=6 if look.observed is None else 2 * look.observed + int(rng.integers(2)))
        for look in looks
    ]
    counts, coarse = count(divided, 2, 2, 3, LEVELS), count(looks, 2, 2, 3)
    assert counts.counts.shape == (2, 2, 3, 7)
    np.testing.assert_array_equal(counts.counts[..., :6].reshape(2, 2, 3, 3, 2).sum(axis=-1), coarse.counts)
    np.testing.assert_array_equal(counts.counts[..., 6], coarse.missed)
    assert counts.missed.sum() == 0
    np.testing.assert_array_equal(counts.accuracy(), coarse.accuracy())
    np.testing.assert_allclose(counts.probabilities(0.5).sum(axis=-1), 1.0)


def test_a_label_of_no_class_is_neither_right_nor_wrong() -> None:
    looks = [Look(0, 0, 0, label) for label in (0, 0, 0, 1, 2, 2)] + [Look(0, 0, 1, 1)]
    counts = count(looks, 1, 1, 2, (0, 1, None))
    assert counts.accuracy().item() == (0.75 + 1.0) / 2
    np.testing.assert_allclose(counts.probabilities(1.0)[0, 0, 0], [4 / 9, 2 / 9, 3 / 9])


@pytest.mark.parametrize("wrong", [-1, 2])
def test_labels_of_unknown_classes_are_refused(wrong: int) -> None:
    with pytest.raises(beltsort.ArgumentError, match=rf"label_classes\b.*{wrong}.*\b0\b.*\b1\b.*None"):
        count([], 1, 1, 2, (0, wrong))
