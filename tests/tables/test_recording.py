"""The folder of recorded scans, read."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from beltsort.errors import RecordingError
from beltsort.tables.recording import HEADER, MANIFEST, read_recording

CELL = {
    "version": 1,
    "classes": ["nut", "bolt"],
    "viewpoints": ["low", "high"],
    "layout": {"positions": 2, "spacing": 0.3},
}


def row(**changed: Any) -> dict[str, Any]:
    pose = np.eye(4).tolist()
    plain = {"file": "0.npy", "viewpoint": "high", "classes": ["bolt", None], "objects": ["x", None]}
    return {**plain, "world_from_camera": pose, **changed}


def folder_of(folder: Path, *rows: Any, cell: Any = CELL) -> Path:
    (folder / HEADER).write_text(json.dumps(cell))
    lines = [line if isinstance(line, str) else json.dumps(line) for line in rows]
    (folder / MANIFEST).write_text("".join(f"{line}\n" for line in lines))
    for name in ("0.npy", "1.npy"):
        np.save(folder / name, np.zeros((1, 3)))
    return folder


def test_a_recording_is_read_and_written_back(tmp_path: Path) -> None:
    rows = (row(), row(file="1.npy", viewpoint="low", classes=[None, "nut"], objects=[None, "y"]))
    recording = read_recording(folder_of(tmp_path, *rows))
    assert recording.header.layout.spacing == 0.3
    first, second = recording.scans
    assert (first.viewpoint, first.true, first.objects) == (1, (1, None), ("x", None))
    assert (second.viewpoint, second.true, second.objects) == (0, (None, 0), (None, "y"))
    assert [json.loads(scan.line(recording.header)) for scan in recording.scans] == list(rows)
    written = tmp_path / HEADER
    written.write_text(recording.header.to_json())
    assert read_recording(tmp_path).header == recording.header


@pytest.mark.parametrize(
    ("second", "said"),
    [
        (row(file="1.npy", classes=["blot", None]), "there is no class 'blot'; did you mean 'bolt'"),
        (row(file="1.npy", viewpoint="hihg"), "there is no viewpoint 'hihg'; did you mean 'high'"),
        (row(file="1.npy", viewpoint=0), "there is no viewpoint 0"),
        (row(file="1.npy", viewpoint=["low"]), "there is no viewpoint"),
        (row(), r"0.npy is listed already in line 1; delete one"),
        (row(file=""), "file is ''"),
        (row(file="1.npy", objects=["x"]), r"objects are \['x'\], expected 2 entries"),
        (row(file="1.npy", classes="bolt"), "classes are bolt, expected 2 entries"),
        (row(file="1.npy", classes=["nut", None]), "object 'x' is said to be bolt and nut"),
        (row(file="1.npy", objects=[None, None]), "give both, or null for both"),
        (row(file="1.npy", objects=[3, None]), "is named 3"),
        (row(file="1.npy", classes=["nut", "nut"], objects=["z", "z"]), "one at two positions"),
        (row(file="1.npy", world_from_camera=[[1, 2]]), "expected a rigid"),
        (row(file="1.npy", world_from_camera=(2 * np.eye(4)).tolist()), "expected a rigid"),
        (row(file="1.npy", world_from_camera="here"), "expected a rigid"),
        (row(file="1.npy", pose=1), "keys are"),
        ({"file": "1.npy"}, r"keys are \['file'\], expected"),
        ('{"file": "1.n', "no JSON"),
        ("7", "keys are 7"),
    ],
)
def test_a_bad_line_is_named(tmp_path: Path, second: Any, said: str) -> None:
    with pytest.raises(RecordingError, match=rf"manifest.jsonl, line 2: .*{said}"):
        read_recording(folder_of(tmp_path, row(), second))


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"version": 2}, "its version is not 1"),
        ({"layout": {"position": 2}}, "unexpected keyword argument 'position'"),
        ({"layout": 3}, "expected the keys version"),
        ({"layout": {"positions": "2"}}, "expected positive numbers"),
        ({"layout": {"positions": 0}}, "expected positive numbers"),
        ({"layout": {"spacing": "wide"}}, "expected positive numbers"),
        ({"clases": []}, "the key 'clases' is unknown"),
        ({"classes": []}, "expected one or more"),
        ({"classes": ["nut", "nut"]}, "none twice"),
        ({"viewpoints": 7}, "expected the keys version"),
    ],
)
def test_a_bad_header_is_refused(tmp_path: Path, changed: dict[str, Any], said: str) -> None:
    with pytest.raises(RecordingError, match=said):
        read_recording(folder_of(tmp_path, row(), cell={**CELL, **changed}))


def test_what_is_missing_is_named(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"cannot read .*cell.json"):
        read_recording(tmp_path)
    folder = folder_of(tmp_path, row(), row(file="2.npy"), row(file="3.npy"))
    with pytest.raises(RecordingError, match=r"2 of 3 files of .* are missing, the first is 2.npy"):
        read_recording(folder)
    (folder / MANIFEST).write_text("")
    with pytest.raises(RecordingError, match="lists 0 scans"):
        read_recording(folder)
    (folder / MANIFEST).unlink()
    with pytest.raises(RecordingError, match=r"cannot read .*manifest.jsonl"):
        read_recording(folder)
