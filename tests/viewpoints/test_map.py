"""The map of viewpoints: what moves cost, what is refused, and how model and cell take it."""

import dataclasses
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import beltsort
from beltsort.errors import ViewpointError
from beltsort.geometry import Points, Pose, on_sphere
from beltsort.sim import CellConfig, SimulatedCell
from beltsort.viewpoints import Sampling, ViewpointMap, map_viewpoints
from beltsort.viewpoints.graph import Edges
from beltsort.viewpoints.sphere import METHODS
from tests.laws import cases

law = cases(40)

SAMPLINGS = st.builds(
    Sampling, method=st.sampled_from(METHODS), count=st.integers(12, 60), seed=st.integers(0, 2**32)
)


def ring(count: int) -> Points:
    return np.array([on_sphere(360.0 / count * i, 45.0, 0.7, np.zeros(3)) for i in range(count)])


def hand_made(edges: list[tuple[int, int]], **changes: Any) -> ViewpointMap:
    """Four points on a ring, p0 to p3, with edges as told."""
    parts: dict[str, Any] = {
        "points": ring(4),
        "reachable": np.ones(4, dtype=bool),
        "edges": np.array(edges, dtype=np.int64).reshape(-1, 2),
        "chosen": (0, 1, 2, 3),
        "names": ("p0", "p1", "p2", "p3"),
        "sampling": Sampling(count=4),
        "lowest": 0.0,
    }
    return ViewpointMap(**(parts | changes))


LINE: list[tuple[int, int]] = [(0, 1), (1, 2), (2, 3)]


@law
@given(sampling=SAMPLINGS, k=st.integers(1, 3))
def test_motion_cost_is_a_metric_but_for_staying(sampling: Sampling, k: int) -> None:
    cost = map_viewpoints(sampling, k, lowest=0.0).motion_cost
    assert cost.shape == (k, k)
    np.testing.assert_array_equal(np.diag(cost), 1.0)
    np.testing.assert_array_equal(cost, cost.T)
    assert cost.min() >= 1.0
    assert (cost[:, None, :] <= cost[:, :, None] + cost[None, :, :]).all()


def test_a_move_costs_the_edges_on_its_way() -> None:
    views = hand_made(LINE)
    assert views.motion_cost.tolist() == [[1, 1, 2, 3], [1, 1, 1, 2], [2, 1, 1, 1], [3, 2, 1, 1]]
    assert views.travel == [[0, 1, 2, 3]] * 4


def test_neighbours_only_restricts_travel() -> None:
    views = hand_made(LINE, neighbours_only=True)
    assert views.travel == [[0, 1], [0, 1, 2], [1, 2, 3], [2, 3]]


def test_unreachable_points_are_neither_asked_for_when_low_nor_connected() -> None:
    asked: list[Pose] = []

    def upstream(pose: Pose) -> bool:
        asked.append(pose)
        return bool(pose[0, 3] > 0.0)

    views = map_viewpoints(reachable=upstream, lowest=30.0)
    heights, upwards = views.points[:, 2], np.array([pose[2, 3] for pose in asked])
    assert len(asked) == (heights >= 0.35).sum()
    assert upwards.min() >= 0.35
    np.testing.assert_array_equal(views.reachable, (heights >= 0.35) & (views.points[:, 0] > 0.0))
    assert views.reachable[views.edges].all()
    for pose in asked:
        np.testing.assert_allclose(pose[:3, 3] + 0.7 * pose[:3, 2], 0.0, atol=1e-12)


def test_viewpoints_stand_on_the_points_that_were_named() -> None:
    views = map_viewpoints(viewpoints=[70, 3, 40], lowest=0.0)
    assert views.chosen == (70, 3, 40)
    assert views.names == ("p1", "p2", "p3")
    for index, viewpoint in zip(views.chosen, views.viewpoints, strict=True):
        np.testing.assert_allclose(viewpoint.pose()[:3, 3], views.points[index], atol=1e-12)


def test_one_viewpoint_is_the_highest_and_staying_costs_one_step() -> None:
    views = map_viewpoints(viewpoints=1)
    assert views.chosen == (99,)
    assert views.motion_cost.tolist() == [[1.0]]
    assert views.travel == [[0]]


def test_model_and_cell_take_it() -> None:
    views = map_viewpoints(viewpoints=4)
    config = CellConfig(viewpoints=views.viewpoints)
    p_obs = np.full((config.layout.positions, 4, 4, 4), 0.25)
    model = beltsort.SortingModel(config.classes, p_obs=p_obs, **views.model_settings())
    cell = SimulatedCell([0], config)
    assert list(cell.viewpoints) == model.viewpoints == list(views.names)
    np.testing.assert_array_equal(model.motion_cost, views.motion_cost)
    assert model.travel == views.travel
    scan = cell.scan(not_before=cell.move_to(3, "move-1"))
    np.testing.assert_allclose(scan.world_from_camera[:3, 3], views.points[views.chosen[3]], atol=1e-12)


def test_the_model_charges_the_way() -> None:
    p_obs = np.array([[np.eye(2), np.full((2, 2), 0.5), np.full((2, 2), 0.5), np.full((2, 2), 0.5)]])
    model = beltsort.SortingModel(["a", "b"], p_obs=p_obs, **hand_made(LINE).model_settings())
    policy = beltsort.Threshold(model, 0.9, viewpoint=0)
    for start, cost in enumerate([1.0, 1.0, 2.0, 3.0]):
        result = beltsort.evaluate(model, policy, batches=1, batch_size=1, viewpoint=start)
        assert result.returns.tolist() == [model.r_max - cost]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: map_viewpoints(reachable=lambda _: False), r"\b100 points\b.*\b0\.7 m\b.*\b15\.0 degrees"),
        (lambda: map_viewpoints(viewpoints=[]), r"names\b.*\[\].*\b0\b.*points"),
        (lambda: map_viewpoints(viewpoints=[50, 50]), r"points\b.*\[50, 50\]"),
        (lambda: map_viewpoints(viewpoints=[2]), r"point 2\b.*\b26, 27, .*\b66\b"),
        (lambda: map_viewpoints(viewpoints=[100]), r"point 100\b.*\b26, 27, "),
        (lambda: map_viewpoints(lowest=91.0), r"\b100 points\b.*\b91\.0 degrees"),
        (lambda: map_viewpoints(lowest=-1.0), r"\blowest\b.*-1\.0\b.*\b0\b.*\b90\b"),
        (lambda: map_viewpoints(neighbours_only=True), r"neighbours_only\b.*p1; p2; p3\b"),
        (lambda: hand_made([(0, 1), (2, 3)]), r"\b2 parts \(2 points: 0, 1; 2 points: 2, 3\)"),
        (lambda: hand_made([]), r"\b4 parts\b"),
        (lambda: hand_made([(1, 0)]), r"edges\b.*\(1, 0\).*\b4\b"),
        (lambda: hand_made([(0, 4)]), r"edges\b.*\(0, 4\).*\b4\b"),
        (lambda: hand_made(LINE, reachable=np.array([True, False, True, True])), r"edges\b.*\(0, 1\).*\b4\b"),
        (lambda: hand_made(LINE, names=("a", "b", "b", "c")), r"names\b.*'a', 'b', 'b', 'c'"),
        (lambda: hand_made(LINE, names=("a", "b", "", "c")), r"names\b.*'a', 'b', '', 'c'"),
        (lambda: hand_made(LINE, names=("a",)), r"names\b.*\['a'\].*\b4\b"),
        (lambda: hand_made(LINE, sampling=Sampling(count=5)), r"points\b.*\b4\b.*\b5\b"),
        (lambda: hand_made(LINE, sampling=Sampling(count=4, radius=1.0)), r"points\[0\] .*\b1\.0 m\b"),
        (lambda: hand_made(LINE, points=-ring(4)), r"points\[0\] .*-0\.49.*half-sphere"),
        (lambda: hand_made(LINE, points=ring(4) * np.nan), r"points\[0\] .*\[nan"),
    ],
)
def test_what_is_refused(make: Any, message: str) -> None:
    with pytest.raises(ViewpointError, match=message):
        make()


def test_counts_that_do_not_fit_are_refused() -> None:
    with pytest.raises(beltsort.ArgumentError, match=r"\b4 viewpoints\b.*\b1\b.*\b2\b"):
        map_viewpoints(Sampling(count=5), 4, lowest=31.0)
    with pytest.raises(beltsort.ArgumentError, match=r"\b0 viewpoints\b.*\b1\b.*\b74\b"):
        map_viewpoints(viewpoints=0)


def test_a_map_in_parts_is_fine_where_nobody_can_stand() -> None:
    edges: Edges = np.array([[0, 1]], dtype=np.int64)
    reachable = np.array([True, True, False, False])
    whole = hand_made(LINE)
    views = dataclasses.replace(whole, edges=edges, reachable=reachable, chosen=(1,), names=("p",))
    assert views.motion_cost.tolist() == [[1.0]]
