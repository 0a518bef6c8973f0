"""What scans found is counted, and a scan that is wrong does not pass silently."""

import json
import warnings
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from beltsort.cli import main
from beltsort.errors import RecordingError
from beltsort.geometry import Pose
from beltsort.perception import Finding, NearestNeighbour, PoseCause, PoseFault, PoseWarning
from beltsort.sim import CellConfig
from beltsort.sim.record import record_simulated
from beltsort.tables import LabelledScan, LabelLog, MatchLog, label_recording, match_recording, read_recording
from beltsort.tables.findings import FindingCounts
from beltsort.tables.log import PositionLabel
from beltsort.tables.matches import Seen
from beltsort.tables.recording import MANIFEST

LIFT = PoseFault(PoseCause.OFFSET, 0.05)


def scan(finding: Finding, label: int | None = None, fault: PoseFault | None = None) -> LabelledScan:
    return LabelledScan(0, (1, None), ("a", None), (label, 0), (finding, Finding.OBJECT), fault)


def test_looks_at_objects_are_counted_by_what_was_found() -> None:
    scans = [scan(Finding.OBJECT, 1)] * 2 + [scan(Finding.OBJECT)] + [scan(Finding.EMPTY)] * 5
    found = FindingCounts.of(scans, ["above"])
    assert (found.looks, found.labelled) == (8, 2)
    assert found.to_dict()["viewpoints"] == {"above": {"label": 2, "no label": 1, "empty": 5}}
    (warning,) = found.warnings()
    assert "5 of 8" in warning
    assert "position 1 from above" in warning
    found.check_labelled()


def test_nothing_labelled_is_an_error_that_tells_the_cause() -> None:
    scans = [scan(Finding.HIDDEN, fault=PoseFault(PoseCause.INVERSE))] * 3
    with pytest.raises(RecordingError, match=r"none of 3 looks .*3 hidden.*inverted"):
        FindingCounts.of(scans, ["above"]).check_labelled()


def test_each_fault_is_told_once_with_its_median_height() -> None:
    heights = (0.04, 0.05, 0.09)
    scans = [scan(Finding.OBJECT, 1, replace(LIFT, height=height)) for height in heights]
    found = FindingCounts.of([*scans, scan(Finding.OBJECT, 1)], ["above"])
    assert found.faults == {LIFT: 3}
    (warning,) = found.warnings()
    assert "3 of 4 scans" in warning
    assert "50 mm above" in warning


def test_labels_alone_have_no_findings() -> None:
    bare = LabelledScan(0, (1, 0), ("a", "b"), (1, None))
    assert FindingCounts.of([bare], ["above"]).to_dict()["viewpoints"] == {
        "above": {"label": 1, "not kept": 1}
    }


def test_logs_keep_findings_and_faults(tmp_path: Path) -> None:
    kept = (PositionLabel(1, Finding.OBJECT, LIFT), PositionLabel(None, Finding.CUT))
    LabelLog(tmp_path / "labels").append({"a": kept, "old": (1, None)})
    log = LabelLog(tmp_path / "labels")
    assert log.positions() == {"a": kept, "old": (PositionLabel(1), PositionLabel(None))}
    assert log.labels() == {"a": (1, None), "old": (1, None)}
    seen = (Seen(None, Finding.HIDDEN, LIFT), Seen(None, Finding.EMPTY))
    MatchLog(tmp_path / "matches").append({"a": seen})
    assert MatchLog(tmp_path / "matches").matches() == {"a": seen}


@pytest.fixture(scope="module")
def recorded(config: CellConfig, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return record_simulated(tmp_path_factory.mktemp("recorded"), config, objects=1, workers=1).folder


def with_poses(recorded: Path, folder: Path, change: Callable[[Pose], Pose]) -> Path:
    """Return a folder with the same scans under changed poses."""
    for file in recorded.iterdir():
        if file.name != MANIFEST:
            (folder / file.name).symlink_to(file)
    lines = [json.loads(line) for line in (recorded / MANIFEST).read_text().splitlines()]
    changed = [
        {**line, "world_from_camera": change(np.array(line["world_from_camera"])).tolist()} for line in lines
    ]
    (folder / MANIFEST).write_text("".join(json.dumps(line) + "\n" for line in changed))
    return folder


def lifted(pose: Pose) -> Pose:
    pose = pose.copy()
    pose[2, 3] += 0.05
    return pose


def millimetres(pose: Pose) -> Pose:
    return np.vstack([pose[:3] * [1.0, 1.0, 1.0, 1000.0], pose[3:]])


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lifted, "50 mm above"),
        (lambda pose: pose @ np.diag([1.0, -1.0, 1.0, 1.0]), "mirrors"),
        (lambda pose: np.eye(4)[[0, 2, 1, 3]] * [[1.0], [1.0], [-1.0], [1.0]] @ pose, "y axis points up"),
        (np.linalg.inv, "inverted"),
        (millimetres, "millimetres"),
    ],
    ids=["lifted", "mirrored", "y up", "inverse", "millimetres"],
)
def test_estimate_tells_what_is_wrong_with_poses(
    change: Callable[[Pose], Pose],
    told: str,
    recorded: Path,
    database_file: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    (tmp_path / "scans").mkdir()
    folder = with_poses(recorded, tmp_path / "scans", change)
    model = tmp_path / "model.json"
    given = ["estimate", str(folder), "--classifier", str(database_file), "-o", str(model), "--json"]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        code = main([*given, "--workers", "1"])
    said = capsys.readouterr()
    assert said.err.count(told) == 1
    assert code == (0 if model.exists() else 2)
    if code == 0:
        found = json.loads(said.out)["findings"]
        assert told in found["pose_faults"][0]["likely"]
        assert sum(found["viewpoints"]["p2"].values()) == 16


def test_labelling_in_python_warns_once_a_kind(
    recorded: Path, database: NearestNeighbour, tmp_path: Path
) -> None:
    recording = read_recording(with_poses(recorded, tmp_path, lifted))
    for label in (label_recording, match_recording):
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            label(recording, database, workers=1)
        (warning,) = told
        assert warning.category is PoseWarning
        assert "8 of 8 scans" in str(warning.message)
