"""The folder of recorded scans, read."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from beltsort.errors import RecordingError
from beltsort.tables import LabelledScan, looks_at_objects
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


def test_modes_are_read_and_written_back(tmp_path: Path) -> None:
    rows = (row(modes=["lying", None]), row(file="1.npy"))
    recording = read_recording(folder_of(tmp_path, *rows))
    assert recording.modes() == {"x": "lying"}
    assert [json.loads(scan.line(recording.header)) for scan in recording.scans] == list(rows)
    seen = [LabelledScan(scan.viewpoint, scan.true, scan.objects, (1, None)) for scan in recording.scans]
    (looks,) = looks_at_objects(seen, recording.modes())
    assert (looks.mode, len(looks.looks)) == ("lying", 2)


@pytest.mark.parametrize(
    ("modes", "said"),
    [
        (["lying"], r"modes .*\['lying'\].*\b2\b"),
        ("lying", r"modes .*\blying\b.*\b2\b"),
        ([3, None], r"object 'x' .*\b3\b"),
        ([None, "lying"], r"object None .*'lying'"),
        (["upright", None], r"object 'x' .*\blying\b.*\bupright\b"),
    ],
)
def test_bad_modes_are_named(tmp_path: Path, modes: Any, said: str) -> None:
    with pytest.raises(RecordingError, match=rf"manifest\.jsonl, line 2\b.*{said}"):
        read_recording(folder_of(tmp_path, row(modes=["lying", None]), row(file="1.npy", modes=modes)))


@pytest.mark.parametrize(
    ("second", "said"),
    [
        (row(file="1.npy", classes=["blot", None]), "class 'blot'.*'bolt'.*nut, bolt"),
        (row(file="1.npy", viewpoint="hihg"), "viewpoint 'hihg'.*'high'.*low, high"),
        (row(file="1.npy", viewpoint=0), "viewpoint 0\\b.*low, high"),
        (row(file="1.npy", viewpoint=["low"]), r"viewpoint \['low'\].*'low'"),
        (row(), r"\b0\.npy\b.*\bline 1\b"),
        (row(file=""), "file .*''"),
        (row(file="1.npy", objects=["x"]), r"objects .*\['x'\].*\b2\b"),
        (row(file="1.npy", classes="bolt"), r"classes .*\bbolt\b.*\b2\b"),
        (row(file="1.npy", classes=["nut", None]), r"object 'x' .*\bbolt\b.*\bnut\b"),
        (row(file="1.npy", objects=[None, None]), r"class 1 .*\bNone\b.*\bnull\b"),
        (row(file="1.npy", objects=[3, None]), r"class 1 .*\b3\b.*\bnull\b"),
        (row(file="1.npy", classes=["nut", "nut"], objects=["z", "z"]), r"objects .*\['z', 'z'\]"),
        (row(file="1.npy", world_from_camera=[[1, 2]]), r"world_from_camera .*\[\[1, 2\]\].*\(4, 4\)"),
        (
            row(file="1.npy", world_from_camera=(2 * np.eye(4)).tolist()),
            r"world_from_camera .*\b2\.0, .*\(4, 4\)",
        ),
        (row(file="1.npy", world_from_camera="here"), r"world_from_camera .*\bhere\b.*\(4, 4\)"),
        (row(file="1.npy", pose=1), "keys .*'pose'.*'viewpoint', 'world_from_camera'"),
        ({"file": "1.npy"}, r"keys .*\['file'\].*'viewpoint', 'world_from_camera'"),
        ('{"file": "1.n', "JSON.*Unterminated string"),
        ("7", r"keys .*\b7\b.*'viewpoint', 'world_from_camera'"),
    ],
)
def test_a_bad_line_is_named(tmp_path: Path, second: Any, said: str) -> None:
    with pytest.raises(RecordingError, match=rf"manifest\.jsonl, line 2\b.*{said}"):
        read_recording(folder_of(tmp_path, row(), second))


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"version": 2}, r"cell\.json\b.*\bversion\b.*\b1\b"),
        ({"layout": {"position": 2}}, r"cell\.json\b.*'position'.*\blayout\b"),
        ({"layout": 3}, r"cell\.json\b.*\bint\b.*\blayout\b"),
        ({"layout": {"positions": "2"}}, r"\blayout\b.*'positions': '2'"),
        ({"layout": {"positions": 0}}, r"\blayout\b.*'positions': 0\b"),
        ({"layout": {"spacing": "wide"}}, r"\blayout\b.*'spacing': 'wide'"),
        ({"clases": []}, r"key 'clases'.*\bclasses, viewpoints\b"),
        ({"classes": []}, r"\bclasses\b.*\[\]"),
        ({"classes": ["nut", "nut"]}, r"\bclasses\b.*\['nut', 'nut'\]"),
        ({"viewpoints": 7}, r"cell\.json\b.*'int'.*\bviewpoints\b"),
    ],
)
def test_a_bad_header_is_refused(tmp_path: Path, changed: dict[str, Any], said: str) -> None:
    with pytest.raises(RecordingError, match=said):
        read_recording(folder_of(tmp_path, row(), cell={**CELL, **changed}))


def test_what_is_missing_is_named(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"No such file.*cell\.json"):
        read_recording(tmp_path)
    folder = folder_of(tmp_path, row(), row(file="2.npy"), row(file="3.npy"))
    with pytest.raises(RecordingError, match=r"\b2 of 3 files\b.*\b2\.npy\b.*\bmanifest\.jsonl\b"):
        read_recording(folder)
    (folder / MANIFEST).write_text("")
    with pytest.raises(RecordingError, match=r"manifest\.jsonl\b.*\b0 scans\b"):
        read_recording(folder)
    (folder / MANIFEST).unlink()
    with pytest.raises(RecordingError, match=r"No such file.*manifest\.jsonl"):
        read_recording(folder)
