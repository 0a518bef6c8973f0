"""Counts of labels that are more than the classes."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import beltsort
from beltsort.perception import LabelRule
from beltsort.tables import Counts, Look, count, table_one, table_two
from beltsort.tables.figure import draw_tables
from beltsort.tables.layout import intervals_text

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


def test_tables_of_levels_as_text_and_picture(tmp_path: Path) -> None:
    rule = LabelRule(("nut", "bolt"), (0.5,), not_recognised=True)
    looks = [Look(0, 0, true, label) for true in range(2) for label in range(5)]
    counts = count(looks, 1, 1, 2, rule.label_classes)
    names = ("nut", "bolt"), ("above",)
    one = table_one(counts.probabilities(1.0), *names, 1, rule.labels).splitlines()
    assert all(name in one[1] for name in rule.labels)
    assert one[2].split() == ["above", *["0.200"] * 5]
    two = table_two(counts.probabilities(1.0), *names, labels=rule.labels).splitlines()
    assert two[2].split() == ["nut", "above", *["0.200"] * 5]
    intervals = intervals_text(counts, 1.0, *names, rule.labels).splitlines()
    assert all(name in intervals[1] for name in rule.labels)
    draw_tables(counts, 1.0, *names, tmp_path / "tables.png", rule.labels)
    assert (tmp_path / "tables.png").read_bytes().startswith(b"\x89PNG")


def test_a_model_with_levels_believes_a_sure_label_more() -> None:
    rule = LabelRule(("nut", "bolt"), (0.5,))
    nut_unsure, nut_sure, bolt_unsure, bolt_sure = range(4)
    nuts = [nut_sure, nut_sure, nut_unsure, bolt_unsure]
    bolts = [bolt_sure, bolt_sure, bolt_unsure, bolt_unsure]
    looks = [Look(0, 0, true, label) for true, labels in enumerate((nuts, bolts)) for label in labels]
    counts = count(looks, 1, 1, 2, rule.label_classes)
    model = counts.model(rule.classes, ("above",), labels=rule.labels)
    assert model.labels == list(rule.labels)
    beliefs = []
    for label in (nut_unsure, nut_sure):
        belief = beltsort.Belief(model)
        belief.observe(0, [label])
        beliefs.append(belief.probabilities[0, 0])
    assert 0.5 < beliefs[0] < beliefs[1]


@pytest.mark.parametrize("wrong", [-1, 2])
def test_labels_of_unknown_classes_are_refused(wrong: int) -> None:
    with pytest.raises(beltsort.ArgumentError, match=rf"label_classes\b.*{wrong}.*\b0\b.*\b1\b.*None"):
        count([], 1, 1, 2, (0, wrong))
