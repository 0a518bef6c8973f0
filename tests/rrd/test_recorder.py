"""What a recording holds, by rerun's own reader, and that a run does not depend on it."""

import shutil
import subprocess
import sys
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rerun.chunk import RrdReader

from beltsort.cli import main
from beltsort.sorting.entries import Decided, Planned, Scanned
from beltsort.sorting.journal import read_journal
from beltsort.sorting.journal_files import JOURNAL

from .conftest import SEED, RecordedRun, record

pytestmark = pytest.mark.slow

PROGRAM = shutil.which("rerun", path=str(Path(sys.executable).parent))
TIMELINES = {"step", "object", "time"}


def rows_of(path: Path) -> dict[str, list[dict[str, Any]]]:
    """Return the rows of each entity, by its path."""
    rows: dict[str, list[dict[str, Any]]] = {}
    for chunk in RrdReader(path).stream():
        rows.setdefault(chunk.entity_path, []).extend(chunk.to_record_batch().to_pylist())
    return rows


@pytest.fixture(scope="module")
def rows(run: RecordedRun) -> dict[str, list[dict[str, Any]]]:
    return rows_of(run.rrd)


def test_every_scan_decision_and_plan_of_the_journal_is_there(
    run: RecordedRun, rows: dict[str, list[dict[str, Any]]]
) -> None:
    assert run.complaints == []
    kinds = Counter(type(entry.content) for entry in read_journal(run.result.folder / JOURNAL))
    model = run.result.model
    for j in range(model.positions):
        assert len(rows[f"/world/candidates/position_{j + 1}"]) == kinds[Scanned]
        assert len(rows[f"/belief/position_{j + 1}"]) == 2 + kinds[Scanned] + kinds[Decided]
    assert len(rows["/world/camera"]) == len(rows["/world/scan"]) == kinds[Scanned]
    for viewpoint in model.viewpoints:
        assert len(rows[f"/plan/look_from_{viewpoint}"]) == kinds[Planned]
    said = [row["TextLog:text"][0] for row in rows["/log"]]
    wrong = [text for text in said if ", wrong: it is " in text]
    assert sum(": decide " in text for text in said) == kinds[Decided] == 10
    assert len(wrong) == 10 - run.result.correct
    assert {"/world/belt", "/world/viewpoints", "/world/viewpoints/half_sphere"} <= set(rows)


def test_timelines_are_steps_objects_and_time(
    run: RecordedRun, rows: dict[str, list[dict[str, Any]]]
) -> None:
    fixed = {"/__properties", "/world", "/world/belt", "/world/belt/rim_1", "/world/belt/rim_2"}
    fixed |= {"/world/viewpoints", "/world/viewpoints/half_sphere"}
    for path, found in rows.items():
        if path not in fixed:
            assert set(found[-1]) >= TIMELINES, path
    steps = [row["step"] for row in rows["/log"]]
    assert steps == sorted(steps)
    assert steps[-1] == run.result.report.steps
    assert {row["object"] for row in rows["/world/scan"]} <= set(range(10))


def test_clouds_and_beliefs_are_the_runs(run: RecordedRun, rows: dict[str, list[dict[str, Any]]]) -> None:
    entries = read_journal(run.result.folder / JOURNAL)
    scans = [entry.content for entry in entries if isinstance(entry.content, Scanned)]
    for j in range(run.result.model.positions):
        clouds = [row["Points3D:positions"] or [] for row in rows[f"/world/candidates/position_{j + 1}"]]
        for cloud, scan in zip(clouds, scans, strict=True):
            assert cloud or scan.findings[j] != "object"
            assert not cloud or scan.findings[j] != "empty"
    centred = np.array(next(row["Points3D:positions"] for row in rows["/world/candidates/position_1"]))
    assert np.abs(centred[:, :2]).max() < 0.1, "the belt end is the origin"
    beliefs = [row["Scalars:scalars"] for row in rows["/belief/position_1"] if "Scalars:scalars" in row]
    for scan in scans:
        assert any(np.allclose(scan.belief[0], belief) for belief in beliefs)


def test_the_run_is_the_same_without_a_recording(run: RecordedRun, tmp_path: Path) -> None:
    from beltsort.sim.demo import run_demo
    from beltsort.sim.prepare import Recipe, prepare

    assert run_demo(prepare(Recipe()), SEED, tmp_path).report == run.result.report


def test_a_recorder_that_fails_says_so_once_and_the_run_goes_on(
    run: RecordedRun, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*arguments: object) -> None:
        raise OSError("no space left on device")

    monkeypatch.setattr("beltsort.rrd.scene.camera", fail)
    spoiled = record(tmp_path)
    assert spoiled.result.report == run.result.report
    (complaint,) = spoiled.complaints
    assert "no space left on device" in complaint
    assert "the run goes on without it" in complaint
    assert len(rows_of(spoiled.rrd)["/log"]) < 10


def test_without_the_extra_the_line_to_type_is_named_before_anything_is_done(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(sys.modules, "rerun", None)
    assert main(["demo", "--rrd", "run.rrd"]) == 2
    assert "pip install 'beltsort[rerun]'" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_a_file_that_cannot_be_written_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["demo", "--rrd", "nowhere/run.rrd"]) == 2
    assert "the recording nowhere/run.rrd cannot be written" in capsys.readouterr().err


@pytest.mark.process
def test_reruns_own_check_finds_no_fault(run: RecordedRun, home: Mapping[str, str]) -> None:
    assert PROGRAM is not None
    done = subprocess.run(
        [PROGRAM, "rrd", "verify", str(run.rrd)], env=home, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert "1 file verified without error" in done.stdout + done.stderr


@pytest.mark.process
def test_recording_touches_no_settings_of_rerun(tmp_path: Path) -> None:
    """Usage statistics are the viewer's; a recording neither asks for them nor writes their settings."""
    import os

    environment = {
        name: value for name, value in os.environ.items() if name != "CI" and not name.startswith("XDG_")
    }
    script = (
        "from tests.rrd.conftest import record; from pathlib import Path; "
        f"run = record(Path({str(tmp_path)!r})); print(len(run.complaints))"
    )
    root = str(Path(__file__).parents[2])
    done = subprocess.run(
        [sys.executable, "-c", script],
        cwd=root,
        env={**environment, "HOME": str(tmp_path), "PYTHONPATH": root},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.stdout == "0\n", done.stderr
    assert [path for path in tmp_path.rglob("*") if "rerun" in path.name or "analytics" in path.name] == []
