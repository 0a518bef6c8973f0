"""Looks grouped by object, and what is counted of them."""

import numpy as np
import pytest

from beltsort import ArgumentError
from beltsort.tables import LabelledScan, count
from beltsort.tables.repeated_looks import NONE, LooksAtObject, RepeatedLooks, TableShape, looks_at_objects
from beltsort.tables.scans import looks as independent_looks
from tests.tables.planted import SHAPE, planted


def random_scans(number: int) -> list[LabelledScan]:
    """Draw scans of a belt that moves from time to time; labels are missing now and then."""
    rng = np.random.default_rng(0)
    scans = []
    for n in range(number):
        first = n // 4  # four scans, then the belt moves by one
        observed = tuple(None if z == 3 else int(z) for z in rng.integers(4, size=2))
        scans.append(
            LabelledScan(
                int(rng.integers(2)), (first % 2, (first + 1) % 2), (f"{first}", f"{first + 1}"), observed
            )
        )
    return scans


def test_first_counts_are_those_of_independent_looks() -> None:
    scans = random_scans(200)
    grouped = RepeatedLooks.of(looks_at_objects(scans), SHAPE)
    square = count(independent_looks(scans), positions=2, viewpoints=2, classes=3)
    np.testing.assert_array_equal(grouped.first_counts(), square.counts[:, :, :2])


def test_an_object_is_followed_as_the_belt_moves() -> None:
    objects = looks_at_objects(random_scans(8))
    assert [len(each.looks) for each in objects] == [4, 8, 4]
    assert [{position for position, _, _ in each.looks} for each in objects] == [{0}, {0, 1}, {1}]


def test_objects_without_name_or_class_are_left_out() -> None:
    assert looks_at_objects([LabelledScan(0, (0, None), (None, "a"), (0, 0))]) == []


def test_counts_have_every_label_once() -> None:
    scans = random_scans(100)
    grouped = RepeatedLooks.of(looks_at_objects(scans), SHAPE)
    labels = [label for scan in scans for label in scan.observed if label is not None]
    assert grouped.counts().sum() == grouped.labelled().sum() == len(labels)
    np.testing.assert_array_equal(
        grouped.counts().sum(axis=(0, 1, 2)), np.bincount(labels, minlength=SHAPE.labels)
    )


def test_chosen_objects_keep_their_looks() -> None:
    looks = planted(10, scans=2, named=True)
    chosen = looks.of_objects([7, 2, 2])
    np.testing.assert_array_equal(chosen.counts(), looks.counts()[[7, 2, 2]])
    np.testing.assert_array_equal(chosen.true, looks.true[[7, 2, 2]])
    np.testing.assert_array_equal(chosen.modes, looks.modes[[7, 2, 2]])
    assert len(looks.of_objects([])) == 0


def test_shuffled_looks_and_their_first() -> None:
    looks = planted(6, scans=3)
    shuffled = looks.shuffled(seed=1)
    np.testing.assert_array_equal(shuffled.counts(), looks.counts())
    assert (shuffled.labels != looks.labels).any()
    for share, number in ((1 / 3, 4), (2 / 3, 8), (1.0, 12), (0.3, 4), (0.05, 1)):
        first = shuffled.first(share)
        assert first.labelled().tolist() == [number] * 6
        np.testing.assert_array_equal(first.labels[first.objects == 4], shuffled.labels[48 : 48 + number])


def test_modes_are_numbered_by_name_within_a_class() -> None:
    objects = [
        LooksAtObject(true, (), mode) for true, mode in ((0, "up"), (1, "lies"), (0, "lies"), (1, None))
    ]
    looks = RepeatedLooks.of(objects, SHAPE)
    assert looks.mode_names == (("lies", "up"), ("lies",))
    assert looks.modes.tolist() == [1, 0, 0, NONE]
    assert looks.known
    assert not looks.without_modes().known


@pytest.mark.parametrize(
    ("bad", "what"),
    [
        (LooksAtObject(2, ()), "class is 2"),
        (LooksAtObject(0, ((2, 0, 0),)), "position is 2"),
        (LooksAtObject(0, ((0, -1, 0),)), "viewpoint is -1"),
        (LooksAtObject(0, ((0, 0, 3),)), "label is 3"),
    ],
)
def test_indices_out_of_range(bad: LooksAtObject, what: str) -> None:
    with pytest.raises(ArgumentError, match=rf"{what}\b.*expected"):
        RepeatedLooks.of([bad], SHAPE)


def test_no_objects() -> None:
    with pytest.raises(ArgumentError, match="0 objects"):
        RepeatedLooks.of([], TableShape(1, 1, 1, 1))
