"""Recorded from the simulated cell, interrupted, labelled."""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from beltsort.errors import CloudError, DatabaseError, RecordingError
from beltsort.perception import FileWarning, LabelRule, NearestNeighbour, fit_label_rule, leave_one_out
from beltsort.sim import CellConfig
from beltsort.sim.collect import collect_matches, collect_scans
from beltsort.sim.record import record_simulated
from beltsort.tables.label import label_recording, match_recording
from beltsort.tables.log import LabelLog
from beltsort.tables.matches import MatchLog
from beltsort.tables.recording import MANIFEST, Recording, read_recording
from beltsort.tables.repeated_looks import looks_at_objects


@pytest.fixture(scope="module")
def recorded(config: CellConfig, tmp_path_factory: pytest.TempPathFactory) -> Recording:
    return record_simulated(tmp_path_factory.mktemp("recorded"), config, objects=2, seed=5, workers=1)


@pytest.fixture
def recording(recorded: Recording, tmp_path: Path) -> Recording:
    """A copy of the first two scans, both of one scene."""
    for scan in recorded.scans[:2]:
        shutil.copy(recorded.folder / scan.file, tmp_path)
    shutil.copy(recorded.folder / "cell.json", tmp_path)
    lines = (recorded.folder / MANIFEST).read_text().splitlines(keepends=True)[:2]
    (tmp_path / MANIFEST).write_text("".join(lines))
    return read_recording(tmp_path)


@pytest.mark.slow
def test_recorded_scans_get_the_labels_of_live_ones(
    recorded: Recording, config: CellConfig, database: NearestNeighbour
) -> None:
    live = collect_scans(database, config, objects=2, seed=5, workers=1)
    assert len(live) == 2 * 4 * 2
    assert label_recording(recorded, database, workers=1) == live


@pytest.mark.slow
def test_recorded_passages_show_every_object_in_every_row(
    config: CellConfig, database: NearestNeighbour, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("beltsort.sim.rounds.OBJECTS_OF_A_CLASS", 1)
    passage = record_simulated(tmp_path, config, objects=1, seed=5, passages=True, workers=1)
    live = collect_scans(database, config, objects=1, seed=5, passages=True, workers=1)
    labelled = label_recording(passage, database, workers=1)
    assert labelled == live
    objects = looks_at_objects(labelled)
    rows = sorted([(j, k) for j in range(2) for k in range(len(config.viewpoints))] * 2)
    assert all(sorted((j, k) for j, k, _ in each.looks) == rows for each in objects)
    assert sorted(each.true for each in objects) == [0, 1, 2, 3]


@pytest.mark.slow
def test_a_rule_labels_matches_like_scans(
    recorded: Recording, config: CellConfig, database: NearestNeighbour, tmp_path: Path
) -> None:
    """Also those of a log that is read again, and of one level as without a rule."""
    live = collect_matches(database, config, objects=2, seed=5, workers=1)
    MatchLog(tmp_path / "matches").append({str(n): scan.seen for n, scan in enumerate(live)})
    read = [replace(live[int(n)], seen=seen) for n, seen in MatchLog(tmp_path / "matches").matches().items()]
    levels = fit_label_rule(config.classes, leave_one_out(database), database.labels.tolist())
    for rule in (LabelRule(config.classes), replace(levels, nothing_seen=True, not_recognised=True)):
        labelled = [scan.labelled(rule) for scan in live]
        again = match_recording(recorded, database, workers=1)
        assert labelled == [scan.labelled(rule) for scan in again] == [scan.labelled(rule) for scan in read]
    assert [scan.labelled(LabelRule(config.classes)) for scan in live] == label_recording(
        recorded, database, workers=1
    )
    assert len({label for scan in live for label in scan.labelled(levels).observed}) > 4


def test_an_interrupted_recording_goes_on(recorded: Recording, config: CellConfig, tmp_path: Path) -> None:
    shutil.copytree(recorded.folder, tmp_path / "copy")
    manifest = tmp_path / "copy" / MANIFEST
    whole = manifest.read_text()
    manifest.write_text("".join(whole.splitlines(keepends=True)[:11]) + whole.splitlines()[11][:100])
    (tmp_path / "copy" / recorded.scans[15].file).unlink()
    again = record_simulated(tmp_path / "copy", config, objects=2, seed=5, workers=1)
    assert manifest.read_text() == whole
    for one, other in zip(recorded.scans, again.scans, strict=True):
        assert (recorded.folder / one.file).read_bytes() == (again.folder / other.file).read_bytes()


def test_another_recording_is_not_mixed_in(recorded: Recording, config: CellConfig) -> None:
    before = (recorded.folder / MANIFEST).read_bytes()
    for changed, seed in ((config, 6), (replace(config, size_spread=0.1), 5)):
        with pytest.raises(RecordingError, match=r"cell\.json .*\bsource\b"):
            record_simulated(recorded.folder, changed, objects=2, seed=seed, workers=1)
    assert (recorded.folder / MANIFEST).read_bytes() == before


def test_a_folder_that_cannot_be_written(config: CellConfig) -> None:
    with pytest.raises(RecordingError, match=r"test_record\.py/folder .*Not a directory"):
        record_simulated(Path(__file__) / "folder", config, objects=1, workers=1)


def test_a_corrected_truth_costs_no_scan(
    recording: Recording, database: NearestNeighbour, monkeypatch: pytest.MonkeyPatch
) -> None:
    log = LabelLog()
    before = label_recording(recording, database, workers=1, log=log)
    corrected = replace(recording, scans=tuple(replace(s, true=(3, None)) for s in recording.scans))
    monkeypatch.setattr("beltsort.tables.label.read_cloud", None)
    after = label_recording(corrected, database, workers=1, log=log)
    assert after == [replace(scan, true=(3, None)) for scan in before]


def test_a_damaged_cloud_is_named_and_the_rest_is_kept(
    recording: Recording, database: NearestNeighbour
) -> None:
    second = recording.folder / recording.scans[1].file
    log = LabelLog()
    np.save(second, np.full((4, 3), np.nan))
    with pytest.raises(CloudError, match=rf"{second.name}\b.*\b4 points\b.*\bfinite\b"):
        label_recording(recording, database, workers=1, log=log)
    assert len(log.labels()) == 1
    second.write_bytes(b"torn")
    with pytest.raises(CloudError, match=rf"{second.name}\b.*\.npy file\b"):
        label_recording(recording, database, workers=1, log=log)


def test_a_cloud_under_two_names_is_refused(recording: Recording, database: NearestNeighbour) -> None:
    first, second = recording.scans
    shutil.copy(recording.folder / first.file, recording.folder / second.file)
    with pytest.raises(RecordingError, match=rf"{second.file} .*{first.file} .*\bmanifest\.jsonl\b"):
        label_recording(recording, database, workers=1)


def test_the_classifier_must_know_the_classes(recording: Recording, database: NearestNeighbour) -> None:
    turned = NearestNeighbour.train(database.descriptors, database.labels, database.classes[::-1])
    with pytest.raises(DatabaseError, match=r"'standard', .*'elongated'\].*\['elongated', .*'standard'\]"):
        label_recording(recording, turned, workers=1)


def as_depth_image(recording: Recording, focal: float) -> Recording:
    """Replace the first scan by its depth image, in tenths of a millimetre, beside its intrinsics."""
    points = np.load(recording.folder / recording.scans[0].file).reshape(480, 640, 3)
    depth = np.nan_to_num(np.round(10_000.0 * points[..., 2])).astype(np.uint16)
    Image.fromarray(depth).save(recording.folder / "first.png")
    camera = {"fx": focal, "fy": focal, "cx": 319.5, "cy": 239.5, "depth_scale": 10_000}
    (recording.folder / "first.json").write_text(json.dumps(camera))
    first = replace(recording.scans[0], file="first.png")
    return replace(recording, scans=(first, *recording.scans[1:]))


@pytest.mark.slow
def test_depth_images_get_the_labels_of_clouds(
    recording: Recording, config: CellConfig, database: NearestNeighbour
) -> None:
    log = LabelLog()
    images = as_depth_image(recording, config.camera.focal)
    assert label_recording(images, database, workers=1, log=log) == label_recording(
        recording, database, workers=1
    )
    corrected = as_depth_image(recording, 500.0)  # other intrinsics: the scan must be labelled again
    label_recording(corrected, database, workers=1, log=log)
    assert len(log.labels()) == 3


def test_a_viewpoint_beside_that_of_the_manifest_is_told(
    recording: Recording, database: NearestNeighbour
) -> None:
    points = np.load(recording.folder / recording.scans[0].file).reshape(-1, 3)
    head = f"FIELDS x y z\nSIZE 8 8 8\nWIDTH {len(points)}\nVIEWPOINT 0 0 0.7 0 1 0 0\nDATA binary\n"
    (recording.folder / "first.pcd").write_bytes(head.encode() + points.astype("<f8").tobytes())
    first = replace(recording.scans[0], file="first.pcd")
    moved = replace(recording, scans=(first, *recording.scans[1:]))
    with pytest.warns(FileWarning, match=rf"\b1 of 2 clouds\b.*first\.pcd\b.*VIEWPOINT\b.*{MANIFEST}"):
        labelled = label_recording(moved, database, workers=1)
    assert labelled == label_recording(recording, database, workers=1)
