import dataclasses
import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import open3d
import pytest

from beltsort.cell import Cell, CommandError, Scan
from beltsort.errors import CellError
from beltsort.geometry import BeltLayout, Points, transform
from beltsort.sim import (
    ArmErrors,
    CellConfig,
    MovingCell,
    PoseMix,
    SensorNoise,
    SimulatedCell,
    SphereViewpoint,
)
from beltsort.sim.bulbs import bulb


def scan(cell: SimulatedCell) -> Scan:
    return cell.scan(not_before=0.0)


def world(scanned: Scan) -> Points:
    """Return the finite points, shape (n, 3), world frame."""
    points = scanned.points[np.isfinite(scanned.points[..., 2])]
    return transform(scanned.world_from_camera, points)


def above_rim(cell: SimulatedCell, position: int) -> Points:
    points = world(scan(cell)) - cell.layout.centre(position)
    near = np.hypot(points[:, 0], points[:, 1]) < cell.layout.crop_radius
    return points[near & (points[:, 2] > cell.layout.rim_height + 0.002)]


def summit(points: Points) -> Points:
    """Return the mean of the points at most 2 mm below the highest; no perspective hides them, shape (3,)."""
    mean: Points = points[points[:, 2] > points[:, 2].max() - 0.002].mean(axis=0)
    return mean


def test_it_is_a_cell() -> None:
    cell: Cell = SimulatedCell([0])
    assert tuple(cell.classes) == ("elongated", "livarno", "mushroom", "standard")
    assert tuple(cell.viewpoints) == ("p1", "p2", "p3")
    assert cell.reject_bin is None


def test_importing_the_protocols_does_not_load_open3d() -> None:
    program = "import sys, beltsort.cell, beltsort.sim; sys.exit('open3d' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", program], check=False).returncode == 0


def test_a_scan_is_organised_and_in_the_optical_frame(perfect: CellConfig) -> None:
    points = scan(SimulatedCell([0, 1], perfect)).points
    assert points.shape == (480, 640, 3)
    v, u = np.argwhere(np.isfinite(points[..., 2])).T
    x, y, z = points[v, u].T
    np.testing.assert_allclose(x / z * 570.0 + 319.5, u, atol=1e-3)
    np.testing.assert_allclose(y / z * 570.0 + 239.5, v, atol=1e-3)


def test_a_perfect_scan_of_empty_cups_shows_belt_and_cups_where_they_are(perfect: CellConfig) -> None:
    cell = SimulatedCell([], perfect)
    for viewpoint in range(3):
        cell.move_to(viewpoint, f"move-{viewpoint}")
        points = world(scan(cell))
        assert points[:, 2].min() > -1e-5
        assert points[:, 2].max() == pytest.approx(cell.layout.rim_height, abs=1e-5)
        assert (np.abs(points[:, 2]) < 1e-5).sum() > 10_000


def test_viewpoints_lie_on_the_half_sphere() -> None:
    for viewpoint in CellConfig().viewpoints:
        eye = viewpoint.pose()[:3, 3]
        assert np.linalg.norm(eye) == pytest.approx(0.7)
        assert eye[2] > 0.0


def test_the_reported_pose_is_the_viewpoints_and_the_true_one_is_off_by_the_arms_error() -> None:
    perfect_arm = SimulatedCell([0], CellConfig(arm=ArmErrors(0.0, 0.0)))
    sloppy = SimulatedCell([0], CellConfig(arm=ArmErrors(0.02, 0.0)))
    a, b = scan(perfect_arm), scan(sloppy)
    np.testing.assert_array_equal(a.world_from_camera, b.world_from_camera)
    assert np.abs(world(a)[:, 2].min() - world(b)[:, 2].min()) > 0.002


def test_the_same_seed_gives_the_same_scan_and_another_seed_another() -> None:
    a, b, c = (scan(SimulatedCell([0, 1, 2], seed=seed)).points for seed in (5, 5, 6))
    np.testing.assert_array_equal(a, b)
    assert not np.array_equal(a, c, equal_nan=True)


def test_scans_of_one_state_differ() -> None:
    cell = SimulatedCell([0, 1])
    assert not np.array_equal(scan(cell).points, scan(cell).points, equal_nan=True)


def test_a_scan_does_not_depend_on_what_was_done_with_earlier_objects() -> None:
    busy, direct = SimulatedCell([0, 1, 2]), SimulatedCell([0, 1, 2])
    for n in range(3):
        busy.move_to(n, f"move-{n}")
        scan(busy)
    busy.move_to(0, "back")
    busy.sort(0, "sort")
    for cell in (busy, direct):
        cell.advance_to(1, "advance")
    np.testing.assert_array_equal(scan(busy).points, scan(direct).points)


def test_the_belt_carries_objects_unchanged(perfect: CellConfig) -> None:
    overhead = dataclasses.replace(perfect, viewpoints=(SphereViewpoint("top", 0.0, 90.0),))
    cell = SimulatedCell([0, 3], overhead)
    before = summit(above_rim(cell, 1))
    cell.advance_to(1, "advance")
    np.testing.assert_allclose(summit(above_rim(cell, 0)), before, atol=1.5e-3)


def test_cups_behind_the_last_object_and_none_labels_are_empty(perfect: CellConfig) -> None:
    cell = SimulatedCell([None, 3], perfect)
    assert len(above_rim(cell, 0)) == 0
    assert len(above_rim(cell, 1)) > 100
    cell.advance_to(1, "advance")
    assert len(above_rim(cell, 0)) > 100
    assert len(above_rim(cell, 1)) == 0


def test_a_neighbour_beyond_the_last_position_is_in_view(perfect: CellConfig) -> None:
    lone, crowded = SimulatedCell([0, 1], perfect), SimulatedCell([0, 1, 2], perfect)
    for cell in (lone, crowded):
        cell.move_to(1, "move")
    assert len(above_rim(lone, 2)) == 0
    assert len(above_rim(crowded, 2)) > 100


def test_sorting_empties_the_cup_and_fills_the_bin(perfect: CellConfig) -> None:
    cell = SimulatedCell([2, 0], perfect)
    assert len(above_rim(cell, 0)) > 100
    cell.sort(1, "sort")
    assert len(above_rim(cell, 0)) == 0
    assert cell.bins == [(0, 1)]


def test_nothing_reaches_a_bin_from_an_empty_cup() -> None:
    cell = SimulatedCell([None])
    cell.sort(1, "sort")
    assert cell.bins == []


def test_a_repeated_command_acts_once() -> None:
    cell = SimulatedCell([2, 0, 1])
    first = cell.move_to(2, "move")
    cell.sort(1, "sort")
    cell.advance_to(1, "advance")
    clock = cell.clock
    assert cell.move_to(2, "move") == first
    cell.sort(1, "sort")
    cell.advance_to(1, "advance")
    assert cell.bins == [(0, 1)]
    assert cell.clock == clock


def test_the_clock_runs_and_scans_wait_for_their_time() -> None:
    cell = SimulatedCell([0])
    stop = cell.move_to(1, "move")
    assert stop == CellConfig().move_seconds
    assert cell.scan(not_before=stop).stamp == stop
    assert cell.scan(not_before=20.0).stamp == 20.0


MOVES = ((0.0, 1.0, 2.0), (1.0, 0.0, 3.0), (2.0, 4.0, 0.5))


@pytest.mark.parametrize("kind", [SimulatedCell, MovingCell])
def test_each_move_takes_its_time(kind: type[SimulatedCell] | type[MovingCell]) -> None:
    cell = kind([0], config=CellConfig(move_seconds=MOVES))
    stops = [cell.move_to(goal, f"move-{n}") for n, goal in enumerate([0, 1, 2, 2, 1])]
    assert stops == [0.0, 1.0, 4.0, 4.5, 8.5]
    with pytest.raises(CommandError, match="takes 3 s, expected at most the timeout of 2 s"):
        cell.move_to(2, "slow", timeout=2.0)


def test_a_time_is_needed_for_each_move() -> None:
    with pytest.raises(CellError, match=r"rows of \[3, 3\] numbers, expected 3 rows of 3"):
        CellConfig(move_seconds=MOVES[:2])


def test_a_reject_bin_takes_undecided_objects() -> None:
    cell = SimulatedCell([0], CellConfig(reject_bin=4))
    cell.sort(4, "sort")
    assert cell.bins == [(0, 4)]


def test_bins_need_not_be_the_classes() -> None:
    cell = SimulatedCell([3, 0], CellConfig(reject_bin=4), bin_names=["glass", "by hand"])
    cell.sort(1, "sort")
    assert cell.bins == [(0, 1)]
    with pytest.raises(CellError, match=r"\blabel\b.*\b2\b.*\b0 to 1 \(glass, by hand\).*\b4\b"):
        cell.sort(2, "another")
    assert [cell.true_class(number) for number in (0, 1, 2)] == [3, 0, None]
    with pytest.raises(CellError, match=r"\breject_bin\b.*\b4\b.*\b5\b.*\(a, b, c, d, e\)"):
        SimulatedCell([0], CellConfig(reject_bin=4), bin_names="abcde")


def sort_twice(cell: SimulatedCell) -> None:
    cell.sort(0, "one")
    cell.sort(0, "two")


def go_back(cell: SimulatedCell) -> None:
    cell.advance_to(1, "one")
    cell.advance_to(0, "two")


def reuse_an_id(cell: SimulatedCell) -> None:
    cell.move_to(0, "one")
    cell.move_to(1, "one")


@pytest.mark.parametrize(
    ("misuse", "message"),
    [
        (sort_twice, r"\bobject 0\b.*advance_to\(1, "),
        (go_back, r"\bindex\b.*\b0\b.*\b1\b.*\b2\b"),
        (reuse_an_id, r"'one'.*move_to\(\d\).*move_to\(\d\)"),
        (lambda cell: cell.advance_to(3, "one"), r"\bindex\b.*\b3\b.*\b0\b.*\b2\b"),
        (lambda cell: cell.move_to(3, "one"), r"\bviewpoint\b.*\b3\b.*\b0\b.*\b2\b.*\(p1, p2, p3\)"),
        (lambda cell: cell.sort(4, "one"), r"\blabel\b.*\b4\b.*\b0\b.*\b3\b.*\(elongated, "),
        (lambda cell: cell.scan(not_before=float("nan")), r"\bnot_before\b.*\bnan\b"),
    ],
)
def test_misuse_is_an_error_that_says_what_to_do(
    misuse: Callable[[SimulatedCell], object], message: str
) -> None:
    with pytest.raises(CellError, match=message):
        misuse(SimulatedCell([0, 1]))


def test_a_refused_command_may_be_corrected_under_its_id() -> None:
    cell = SimulatedCell([0, 1])
    with pytest.raises(CellError):
        cell.sort(9, "sort")
    cell.sort(0, "sort")
    assert cell.bins == [(0, 0)]


@pytest.mark.parametrize(
    ("labels", "seed", "message"),
    [([4], 0, r"true_labels\[0\].*\b4\b.*\bNone\b.*\b0\b.*\b3\b"), ([0], -1, r"\bseed\b.*-1\b")],
)
def test_bad_runs_are_errors(labels: list[int], seed: int, message: str) -> None:
    with pytest.raises(CellError, match=message):
        SimulatedCell(labels, seed=seed)


def test_a_mesh_file_replaces_a_shape(tmp_path: Path, perfect: CellConfig) -> None:
    path = tmp_path / "tall.ply"
    tall = bulb("elongated").scaled(1.0, 2.0)
    open3d.io.write_triangle_mesh(
        path,
        open3d.geometry.TriangleMesh(
            open3d.utility.Vector3dVector(tall.vertices), open3d.utility.Vector3iVector(tall.triangles)
        ),
    )
    upright = dataclasses.replace(perfect, poses=dataclasses.replace(perfect.poses, leaning=0.0, lying=0.0))
    replaced = SimulatedCell([0], dataclasses.replace(upright, meshes={"elongated": str(path)}))
    assert above_rim(replaced, 0)[:, 2].max() > above_rim(SimulatedCell([0], upright), 0)[:, 2].max() + 0.05


def test_configurations_are_checked_and_json() -> None:
    json.dumps(dataclasses.asdict(CellConfig(meshes={"standard": "bulb.stl"})))
    with pytest.raises(CellError, match=r"\['tube'\].*\['elongated', "):
        CellConfig(meshes={"tube": "bulb.stl"})
    with pytest.raises(CellError, match=r"\breject_bin\b.*\b3\b.*\bNone\b.*\b4\b"):
        CellConfig(reject_bin=3)
    with pytest.raises(CellError, match=r"\bclass\b.*'standard', 'standard'"):
        CellConfig(classes=("standard", "standard"))


@pytest.mark.parametrize(
    ("kind", "settings", "said"),
    [
        (
            PoseMix,
            {"upright": 0.0, "leaning": 0.0, "lying": 0.0},
            r"upright, leaning and lying\b.*\(0\.0, 0\.0, 0\.0\)",
        ),
        (PoseMix, {"leaning": -0.1}, r"upright, leaning and lying\b.*-0\.1\b"),
        (PoseMix, {"lying": float("nan")}, r"upright, leaning and lying\b.*\bnan\b"),
        (SensorNoise, {"disparity_step": 0.0}, r"\bdisparity_step\b.*\b0\.0\b.*\b0\b"),
        (SensorNoise, {"axial_window": 0}, r"\baxial_window\b.*\b0\b.*\b0\b"),
        (SensorNoise, {"gloss_patch": 0}, r"\bgloss_patch\b.*\b0\b.*\b0\b"),
        (SensorNoise, {"grazing_width": float("nan")}, r"\bgrazing_width\b.*\bnan\b"),
        (CellConfig, {"size_spread": -0.1}, r"\bsize_spread\b.*-0\.1\b.*\b0\b"),
        (CellConfig, {"size_spread": float("nan")}, r"\bsize_spread\b.*\bnan\b"),
        (CellConfig, {"upstream": -1}, r"\bupstream\b.*-1\b.*\b0\b"),
        (CellConfig, {"layout": BeltLayout(positions=0)}, r"\blayout\.positions\b.*\b0\b.*\b1\b"),
    ],
)
def test_numbers_without_sense_are_refused(
    kind: Callable[..., object], settings: dict[str, Any], said: str
) -> None:
    with pytest.raises(CellError, match=said):
        kind(**settings)


def test_what_has_left_the_belt_takes_no_memory() -> None:
    cell = SimulatedCell([0] * 10)
    for number in range(1, 8):
        cell.advance_to(number, f"advance-{number}")
        cell.scan(not_before=0.0)
    assert min(cell._world._objects) == 7
