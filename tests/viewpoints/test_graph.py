"""The neighbour graph: who is whose neighbour, and how far is it."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from beltsort.geometry import Points, on_sphere
from beltsort.viewpoints import Sampling
from beltsort.viewpoints.graph import BEARINGS, Edges, bearings, components, neighbour_edges, steps_from
from beltsort.viewpoints.sphere import METHODS
from tests.laws import cases

law = cases(40)

SAMPLINGS = st.builds(
    Sampling, method=st.sampled_from(METHODS), count=st.integers(1, 40), seed=st.integers(0, 2**32)
)


def everywhere(points: Points) -> np.ndarray:
    return np.ones(len(points), dtype=bool)


def half_of(points: Points, seed: int) -> np.ndarray:
    return np.random.default_rng(seed).random(len(points)) < 0.5


def turned(bearing: float, wanted: float) -> float:
    """The angle between two bearings, degrees."""
    return abs((bearing - wanted + 180.0) % 360.0 - 180.0)


def nearest_by_bearing(points: Points, start: int, others: list[int]) -> set[int]:
    """The definition, word by word: angles from arc cosines, one bearing after the other."""
    found = set()
    length = float(points[start] @ points[start])
    for wanted in BEARINGS.values():
        within = [j for j in others if turned(bearings(points[start], points[[j]])[0], wanted) <= 45.0]
        if within:
            found.add(
                min(within, key=lambda j: np.arccos(np.clip(points[j] @ points[start] / length, -1, 1)))
            )
    return found


def as_pairs(edges: Edges) -> set[tuple[int, int]]:
    return {(i, j) for i, j in edges.tolist()}


@law
@given(sampling=SAMPLINGS, seed=st.integers(0, 2**32))
def test_edges_lead_to_the_nearest_within_45_degrees_of_a_bearing(sampling: Sampling, seed: int) -> None:
    points = sampling.points()
    reachable = half_of(points, seed)
    nodes = np.flatnonzero(reachable).tolist()
    expected = {
        (min(i, j), max(i, j))
        for i in nodes
        for j in nearest_by_bearing(points, i, [node for node in nodes if node != i])
    }
    assert as_pairs(neighbour_edges(points, reachable)) == expected


@pytest.mark.parametrize(("name", "azimuth", "elevation"), [("east", 31, 40), ("west", 29, 40)])
def test_bearings_are_those_of_a_globe(name: str, azimuth: float, elevation: float) -> None:
    start = on_sphere(30, 40, 0.7, np.zeros(3))
    aside, above, below = (
        on_sphere(a, e, 0.7, np.zeros(3)) for a, e in [(azimuth, elevation), (30, 41), (30, 39)]
    )
    found = bearings(start, np.array([aside, above, below]))
    np.testing.assert_allclose(found[0], BEARINGS[name], atol=0.5)
    assert turned(found[1], BEARINGS["north"]) < 1e-6
    assert turned(found[2], BEARINGS["south"]) < 1e-6


def test_the_top_has_neighbours_on_all_sides() -> None:
    ring = [on_sphere(azimuth, 60, 0.7, np.zeros(3)) for azimuth in (0, 90, 180, -90)]
    points = np.array([[0.0, 0.0, 0.7], *ring])
    np.testing.assert_allclose(bearings(points[0], points[1:]), [180.0, 90.0, 0.0, -90.0], atol=1e-9)
    assert {(0, 1), (0, 2), (0, 3), (0, 4)} <= as_pairs(neighbour_edges(points, everywhere(points)))


@law
@given(azimuth=st.floats(-180, 180), tilt=st.floats(0.0, 1e-6))
def test_near_the_top_no_neighbour_is_lost(azimuth: float, tilt: float) -> None:
    ring = [on_sphere(a, 60, 0.7, np.zeros(3)) for a in (10, 100, 190, -80)]
    points = np.array([on_sphere(azimuth, 90 - tilt, 0.7, np.zeros(3)), *ring])
    edges = as_pairs(neighbour_edges(points, everywhere(points)))
    assert {(0, 1), (0, 2), (0, 3), (0, 4)} <= edges


def test_far_apart_on_the_horizon() -> None:
    points = np.array([[0.7, 0.0, 0.0], [-0.7, 0.0, 0.0]])
    assert as_pairs(neighbour_edges(points, everywhere(points))) == {(0, 1)}


@law
@given(sampling=SAMPLINGS, seed=st.integers(0, 2**32))
def test_the_graph_of_a_sample_is_connected(sampling: Sampling, seed: int) -> None:
    points = sampling.points()
    reachable = half_of(points, seed)
    nodes = np.flatnonzero(reachable).tolist()
    assert len(components(nodes, neighbour_edges(points, reachable), len(points))) == min(len(nodes), 1)


@pytest.mark.parametrize("count", [0, 1])
def test_too_few_points_for_an_edge(count: int) -> None:
    points = Sampling(count=3).points()
    assert neighbour_edges(points, np.arange(3) < count).shape == (0, 2)


@law
@given(pairs=st.sets(st.tuples(st.integers(0, 7), st.integers(0, 7)), max_size=14))
def test_steps_and_components_are_those_of_matrix_powers(pairs: set[tuple[int, int]]) -> None:
    edges = np.array(sorted((i, j) for i, j in pairs if i < j), dtype=np.int64).reshape(-1, 2)
    joined = np.eye(8, dtype=int)
    joined[edges[:, 0], edges[:, 1]] = joined[edges[:, 1], edges[:, 0]] = 1
    within = [np.linalg.matrix_power(joined, steps) > 0 for steps in range(9)]
    for start in range(8):
        expected = [min((n for n in range(9) if within[n][start, end]), default=np.inf) for end in range(8)]
        assert steps_from(start, edges, 8).tolist() == expected
    parts = components(range(8), edges, 8)
    assert sorted(node for part in parts for node in part) == list(range(8))
    for part in parts:
        assert np.flatnonzero(within[8][part[0]]).tolist() == part
    assert [len(part) for part in parts] == sorted((len(part) for part in parts), reverse=True)
