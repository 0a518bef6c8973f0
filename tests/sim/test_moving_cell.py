"""A simulated belt that never stops, and scans that are exposed while it moves."""

from dataclasses import replace

import numpy as np
import pytest

from beltsort.cell import Arm, CommandError, DepthCamera, Outcome, Scan
from beltsort.errors import CellError
from beltsort.geometry import Points, SphereViewpoint, transform
from beltsort.perception import find_cups
from beltsort.sim import BeltDrive, CellConfig, MovingCell, SimulatedCell
from beltsort.tracking import BeltMotion, without_smear

STILL = BeltDrive(belt_speed=0.0)


def cups_of(cell: MovingCell, scan: Scan) -> list[float]:
    return [cup.place for cup in find_cups(scan, cell.layout)]


@pytest.fixture
def overhead(perfect: CellConfig) -> CellConfig:
    """The belt runs along the image's columns, so that each end of a cup is in rows of its own."""
    return replace(perfect, viewpoints=(SphereViewpoint("top", 0.0, 90.0),))


def test_its_arm_and_camera_are_those_of_a_cell() -> None:
    arm: Arm = MovingCell([0])
    camera: DepthCamera = MovingCell([0])
    assert arm.health().ready
    assert camera.health().ready


def test_scans_of_a_belt_that_stands_are_those_of_the_cell_with_stops_to_the_bit() -> None:
    still, stops = MovingCell([0, 2, 1], STILL, seed=4), SimulatedCell([0, 2, 1], seed=4)
    for viewpoint in (0, 1, 2):
        scans = [
            cell.scan(not_before=cell.move_to(viewpoint, f"move-{viewpoint}")) for cell in (still, stops)
        ]
        np.testing.assert_array_equal(scans[0].points, scans[1].points)
        np.testing.assert_array_equal(scans[0].world_from_camera, scans[1].world_from_camera)
        assert scans[0].stamp == scans[1].stamp


def test_slices_of_the_same_moment_make_the_whole_view() -> None:
    scene, pose = MovingCell([0, 1], STILL)._world.scene(), CellConfig().viewpoints[2].pose()
    whole, sliced = scene.view(pose), scene.rolling_view([pose] * 7)
    assert (whole.top, whole.left) == (sliced.top, sliced.left)
    np.testing.assert_allclose(whole.depth, sliced.depth, atol=1e-6)
    np.testing.assert_array_equal(whole.lit, sliced.lit)


def test_the_belt_moves_whenever_time_passes() -> None:
    cell = MovingCell([0, 1], BeltDrive(belt_speed=0.1))
    cell.wait(0.5)
    assert cell.place(1) == pytest.approx(0.18 - 0.05)
    stop = cell.move_to(1, "move")
    assert cell.place(1) == pytest.approx(0.18 - 0.1 * stop)
    cell.set_speed(0.0)
    cell.wait(1.0)
    assert cell.place(1) == pytest.approx(0.18 - 0.1 * stop)
    assert cell.place(1, time=0.0) == pytest.approx(0.18)


@pytest.mark.parametrize("speed", [0.1, 0.5])
def test_objects_are_seen_where_they_are_in_the_middle_of_a_short_exposure(
    overhead: CellConfig, speed: float
) -> None:
    cell = MovingCell([None] * 8, BeltDrive(belt_speed=speed, exposure=0.001), overhead)
    for _ in range(2):
        cell.wait(0.2)
        scan = cell.scan(not_before=0.0)
        truth = [x for x in cell.on_belt(scan.stamp + 0.0005).values() if -0.05 < x < 0.3]
        found = cups_of(cell, scan)
        assert all(min(abs(place - x) for place in found) < 0.0015 for x in truth)


def rim(scan: Scan, x: float, height: float) -> Points:
    """Return the points of a cup's rim, world frame, shape (n, 3)."""
    world = transform(scan.world_from_camera, scan.points[np.isfinite(scan.points[..., 2])])
    return world[(np.abs(world[:, 2] - height) < 1e-4) & (np.abs(world[:, 0] - x) < 0.07)]


def test_a_long_exposure_smears_what_the_belt_carries_and_the_motion_corrects_it(
    overhead: CellConfig,
) -> None:
    belt = BeltDrive(belt_speed=0.5, exposure=0.2, slices=48)
    cell = MovingCell([None] * 3, belt, overhead)
    motion = BeltMotion()
    motion.add(cell.encoder())
    scan = cell.scan(not_before=0.0)
    motion.add(cell.encoder())
    x = cell.place(1, scan.stamp + belt.exposure / 2.0)
    height = cell.layout.rim_height

    def length(seen: Scan) -> float:
        return float(np.ptp(rim(seen, x, height)[:, 0]))

    regular = 2.0 * cell.layout.rim_radius
    assert abs(length(scan) - regular) > 0.005
    corrected = without_smear(scan, motion, belt.exposure)
    assert length(corrected) == pytest.approx(regular, abs=0.004)
    assert min(abs(place - x) for place in cups_of(cell, corrected)) < 0.002


def test_without_motion_nothing_is_corrected(overhead: CellConfig) -> None:
    cell = MovingCell([0, 1], STILL, overhead)
    motion = BeltMotion()
    motion.add(cell.encoder())
    scan = cell.scan(not_before=0.0)
    motion.add(cell.encoder())
    np.testing.assert_array_equal(without_smear(scan, motion, 0.03).points, scan.points)


def test_the_camera_moves_during_an_exposure_that_begins_on_the_way(perfect: CellConfig) -> None:
    def on_the_way(exposure: float) -> tuple[Scan, Points]:
        cell = MovingCell([], BeltDrive(belt_speed=0.0, exposure=exposure, slices=24), perfect)
        end = cell.start_move(1)
        scan = cell.scan(not_before=end / 2.0)
        return scan, transform(scan.world_from_camera, scan.points[np.isfinite(scan.points[..., 2])])

    (scan, sharp), (_, smeared) = on_the_way(0.0), on_the_way(0.1)
    eye = scan.world_from_camera[:3, 3]
    assert np.linalg.norm(eye) == pytest.approx(0.7)
    assert not any(np.allclose(eye, v.pose()[:3, 3], atol=0.05) for v in perfect.viewpoints)
    assert sharp[:, 2].min() > -1e-5
    assert smeared[:, 2].min() < -0.002


def test_places_jitter_about_the_pitch_and_are_the_same_for_a_seed() -> None:
    def places(seed: int) -> list[float]:
        cell = MovingCell([0] * 200, BeltDrive(belt_speed=0.0, pitch_jitter=0.01), seed=seed)
        return [cell.place(n) for n in range(200)]

    offsets = np.array(places(1)) - 0.18 * np.arange(200)
    assert offsets.std() == pytest.approx(0.01, rel=0.2)
    assert np.abs(offsets).max() <= 0.03
    assert places(1) == places(1) != places(2)


def test_cups_are_empty_as_often_as_said() -> None:
    cell = MovingCell([1] * 400, BeltDrive(empty=0.3), seed=2)
    empty = sum(cell.true_class(n) is None for n in range(400))
    assert empty == pytest.approx(120, abs=30)


def test_the_encoder_has_the_errors_it_is_given() -> None:
    exact, wrong = (MovingCell([], BeltDrive(belt_speed=0.1, encoder_scale=scale)) for scale in (1.0, 1.01))
    for cell in (exact, wrong):
        cell.wait(10.0)
    assert exact.encoder().travel == pytest.approx(1.0)
    assert wrong.encoder().travel == pytest.approx(1.01)
    jittery = MovingCell([], BeltDrive(belt_speed=0.0, encoder_jitter=0.002))
    assert np.std([jittery.encoder().travel for _ in range(300)]) == pytest.approx(0.002, rel=0.15)


def test_a_stop_stops_the_belt() -> None:
    cell = MovingCell([0], BeltDrive(belt_speed=0.5))
    cell.stop()
    cell.wait(3.0)
    assert cell.place(0) == 0.0


def test_a_move_is_executed_once() -> None:
    cell = MovingCell([0])
    assert cell.outcome_of("a") is Outcome.NOT_DONE
    stop = cell.move_to(1, "a")
    cell.wait(1.0)
    assert cell.move_to(1, "a") == stop
    assert cell.outcome_of("a") is Outcome.DONE
    with pytest.raises(CommandError, match="belongs to a move to viewpoint 1"):
        cell.move_to(2, "a")


def test_commands_out_of_range_are_refused() -> None:
    cell = MovingCell([0])
    with pytest.raises(CommandError, match="viewpoint is 7"):
        cell.start_move(7)
    with pytest.raises(CommandError, match="the move takes 2 s"):
        cell.move_to(1, "a", timeout=1.0)
    with pytest.raises(CommandError, match="waiting for the scan takes"):
        cell.scan(not_before=100.0, timeout=1.0)
    with pytest.raises(CellError, match="not_before is nan"):
        cell.scan(not_before=float("nan"))
    for wrong in (cell.wait, cell.set_speed):
        with pytest.raises(CellError, match=r"is -1\.0, expected"):
            wrong(-1.0)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("belt_speed", -0.1),
        ("exposure", float("inf")),
        ("slices", 0),
        ("empty", 1.5),
        ("encoder_scale", 0.0),
    ],
)
def test_settings_out_of_range_are_refused(name: str, value: float) -> None:
    with pytest.raises(CellError, match=f"{name} is {value}"):
        BeltDrive(**{name: value})  # type: ignore[arg-type] # the mistake


def test_cups_that_could_touch_are_refused() -> None:
    with pytest.raises(CellError, match="could touch"):
        MovingCell([0], BeltDrive(pitch_jitter=0.02))
