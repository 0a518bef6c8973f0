"""What is recorded is what is played back."""

from pathlib import Path

import numpy as np
import pytest

from beltsort.cell import Arm, Belt, DepthCamera, Outcome, Scan
from beltsort.drivers.replay import (
    Recorder,
    RecordingArm,
    RecordingBelt,
    RecordingCamera,
    Replay,
    ReplayOptions,
)
from beltsort.errors import CellError
from beltsort.sim import Camera, CellConfig, SimulatedCell

SMALL = CellConfig(camera=Camera(width=64, height=48, focal=57.0))


def test_a_run_of_a_simulated_cell_comes_back(tmp_path: Path) -> None:
    cell = SimulatedCell([0, 3], SMALL, seed=2)
    taken = []
    with Recorder(tmp_path / "run") as recorder:
        camera: DepthCamera = RecordingCamera(cell, recorder)
        arm: Arm = RecordingArm(cell, recorder, cell.viewpoints)
        belt: Belt = RecordingBelt(cell, recorder)
        for n, viewpoint in enumerate([1, 0]):
            stop = arm.move_to(viewpoint, f"move-{n}")
            taken += [camera.scan(not_before=stop) for _ in range(2)]
            assert arm.outcome_of(f"move-{n}") is Outcome.DONE
        taken.append(camera.scan(not_before=belt.advance_to(1, "advance-1")))
        assert arm.health() == belt.health() == camera.health() == cell.health()
        assert belt.outcome_of("advance-1") is Outcome.DONE
    with Replay(ReplayOptions(str(tmp_path / "run"), cell.viewpoints)) as again:
        played = []
        for n, viewpoint in enumerate([1, 0]):
            stop = again.move_to(viewpoint, f"move-{n}")
            played += [again.scan(not_before=stop) for _ in range(2)]
        played.append(again.scan(not_before=again.advance_to(1, "advance-1")))
    for before, after in zip(taken, played, strict=True):
        same(before, after)


def same(before: Scan, after: Scan) -> None:
    np.testing.assert_array_equal(after.points, before.points.astype(np.float32))
    np.testing.assert_allclose(after.world_from_camera, before.world_from_camera, atol=1e-15)
    assert after.stamp == pytest.approx(before.stamp, abs=1e-9)
    assert after.frame == before.frame


@pytest.mark.parametrize("shape", [(4, 5, 3), (7, 3)])
def test_float32_points_come_back_bit_by_bit(shape: tuple[int, ...], tmp_path: Path) -> None:
    rng = np.random.default_rng(5)
    points = rng.normal(size=shape).astype(np.float32).astype(np.float64)
    points[0] = np.nan
    points[-1, ..., 0] = -0.0
    with Recorder(tmp_path / "run") as recorder:
        recorder.stopped("/beltsort/viewpoint", "p1", 1e9)
        recorder.scan(Scan(points, np.eye(4), stamp=1e9 + 0.125, frame="optical"))
    with Replay(ReplayOptions(str(tmp_path / "run"), ("p1",))) as cell:
        scan = cell.scan(not_before=cell.move_to(0, "one"))
    assert scan.points.tobytes() == points.tobytes()
    assert (scan.stamp, scan.frame) == (1e9 + 0.125, "optical")


def test_nothing_is_overwritten(tmp_path: Path) -> None:
    (tmp_path / "run").mkdir()
    with pytest.raises(CellError, match=r"/run\b.*\bexists\b"):
        Recorder(tmp_path / "run")


def test_a_closed_recording_takes_no_more(tmp_path: Path) -> None:
    recorder = Recorder(tmp_path / "run")
    recorder.close()
    recorder.close()
    with pytest.raises(CellError, match=r"/run\b.*\bclosed\b"):
        recorder.stopped("/beltsort/viewpoint", "p1", 0.0)
