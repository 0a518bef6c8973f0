"""Cups are found where they stand, and candidates are cut at any place along the belt."""

import numpy as np
import pytest

from beltsort.errors import CloudError
from beltsort.geometry import BeltLayout, Points
from beltsort.perception import Finding, find_cups, segment
from tests.perception.belt_scene import Scene

LAYOUT = BeltLayout()
ROUND = (0.03, 0.03, 0.03)
BULGE = (0.03, 0.02, 0.05)


def scene_at(*places: float, seed: int = 7) -> Scene:
    return Scene(LAYOUT.at(places), np.random.default_rng(seed))


@pytest.mark.parametrize("places", [(0.0, 0.18), (-0.031, 0.104, 0.247), (0.05, 0.135)])
def test_cups_are_found_where_they_stand(places: tuple[float, ...]) -> None:
    scene = scene_at(*places)
    objects = [scene.ellipsoid(0, ROUND)]
    found = find_cups(scene.scan(scene.belt(), *map(scene.cup, range(len(places))), *objects), LAYOUT)
    assert [cup.place for cup in found] == pytest.approx(places, abs=0.002)


def test_half_a_rim_is_enough_and_does_not_displace_the_cup() -> None:
    scene = scene_at(0.07)
    cup = scene.cup(0)
    (found,) = find_cups(scene.scan(scene.belt(), cup[cup[:, 0] > 0.07]), LAYOUT)
    assert found.place == pytest.approx(0.07, abs=0.003)
    assert 0.4 < found.seen < 0.6


def test_an_empty_belt_has_no_cups() -> None:
    scene = scene_at()
    assert find_cups(scene.scan(scene.belt()), LAYOUT) == ()


def test_rims_as_low_as_the_belt_are_refused() -> None:
    scene = scene_at()
    with pytest.raises(CloudError, match=r"rim_height is 0\.0 m, expected above"):
        find_cups(scene.scan(scene.belt()), BeltLayout(rim_height=0.0))


def x_of(points: Points | None) -> float:
    assert points is not None
    return float(points[:, 0].mean())


def test_candidates_are_cut_at_the_places_given() -> None:
    scene = scene_at(-0.02, 0.11, 0.25)
    scan = scene.scan(
        scene.belt(), *map(scene.cup, range(3)), scene.ellipsoid(0, ROUND), scene.ellipsoid(2, BULGE)
    )
    segmented = segment(scan, LAYOUT.at([0.25, -0.02, 0.11]))
    assert x_of(segmented.candidates[0]) == pytest.approx(0.25, abs=0.004)
    assert x_of(segmented.candidates[1]) == pytest.approx(-0.02, abs=0.004)
    assert segmented.findings[:2] == (Finding.OBJECT, Finding.OBJECT)
    assert segmented.candidates[2] is None


def test_regular_places_give_the_same_as_the_layout() -> None:
    scene = Scene(LAYOUT, np.random.default_rng(3))
    scan = scene.scan(scene.belt(), scene.cup(0), scene.cup(1), scene.ellipsoid(0, BULGE))
    regular, placed = segment(scan, LAYOUT), segment(scan, LAYOUT.at([0.0, LAYOUT.spacing]))
    assert regular.findings == placed.findings
    np.testing.assert_array_equal(regular.candidates[0], placed.candidates[0])


def test_no_places_give_no_candidates() -> None:
    scene = scene_at()
    assert segment(scene.scan(scene.belt()), LAYOUT.at([])).candidates == ()
