"""Well-spread viewpoints."""

from itertools import combinations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from beltsort.geometry import Points
from beltsort.viewpoints import Sampling
from beltsort.viewpoints.choice import well_spread
from tests.laws import cases

law = cases(40)


def angles(points: Points) -> np.ndarray:
    directions = points / np.linalg.norm(points, axis=-1, keepdims=True)
    angle: np.ndarray = np.arccos(np.clip(directions @ directions.T, -1.0, 1.0))
    return angle


def smallest_angle(angle: np.ndarray, chosen: tuple[int, ...]) -> float:
    return float(min(angle[i, j] for i, j in combinations(chosen, 2)))


@law
@given(count=st.integers(2, 10), seed=st.integers(0, 2**32), data=st.data())
def test_at_least_half_as_far_apart_as_possible(count: int, seed: int, data: st.DataObject) -> None:
    angle = angles(points := Sampling("uniform", count, seed=seed).points())
    wanted = data.draw(st.integers(2, count))
    chosen = well_spread(points, range(count), wanted)
    assert len(set(chosen)) == wanted
    best = max(smallest_angle(angle, choice) for choice in combinations(range(count), wanted))
    assert smallest_angle(angle, tuple(chosen)) >= 0.5 * best - 1e-9


@law
@given(seed=st.integers(0, 2**32), data=st.data())
def test_only_from_those_offered_the_highest_first_and_then_the_same_order(
    seed: int, data: st.DataObject
) -> None:
    points = Sampling("uniform", 20, seed=seed).points()
    among = sorted(data.draw(st.sets(st.integers(0, 19), min_size=1)))
    order = well_spread(points, among, len(among))
    assert sorted(order) == among
    assert points[order[0], 2] == points[among, 2].max()
    for count in range(1, len(among)):
        assert well_spread(points, among, count) == order[:count]
