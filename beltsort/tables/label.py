"""Classify recorded scans."""

import hashlib
import warnings
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias

from beltsort.cell.protocols import Scan
from beltsort.errors import CloudError, RecordingError
from beltsort.perception import (
    Classifier,
    FileWarning,
    Perceived,
    Perception,
    PerceptionConfig,
    PoseFault,
    PoseWarning,
    read_cloud,
)
from beltsort.perception.checks import counted_warnings
from beltsort.perception.classifier import check_classes
from beltsort.perception.clouds import files_of, has_viewpoint
from beltsort.tables.findings import fault_texts, faults_of
from beltsort.tables.log import LabelLog, PositionLabel, PositionLabels, label_missing
from beltsort.tables.matches import MatchedScan, Matches, MatchLog, Seen
from beltsort.tables.recording import MANIFEST, RecordedScan, Recording
from beltsort.tables.scans import LabelledScan
from beltsort.util.keyed_log import KeyedLog
from beltsort.util.processes import Progress

Piece: TypeAlias = tuple[str, RecordedScan]
"""A scan and its key in the log."""


def label_recording(
    recording: Recording,
    classifier: Classifier,
    config: PerceptionConfig | None = None,
    *,
    workers: int | None = None,
    progress: Progress | None = None,
    log: LabelLog | None = None,
) -> list[LabelledScan]:
    """Label the scans of a recording with classes.

    Parameters
    ----------
    recording
        The folder.
    classifier
        Its classes must be the recording's. More than one process needs one that can be pickled.
    config
        Settings of perception, as in `Perception`.
    workers, progress
        As in `beltsort.util.processes.in_processes`.
    log
        Keeps each label as soon as it is known. Scans are recognised by the content of their clouds and their
        poses, so correcting a class in the manifest needs no scan to be labelled again.

    Raises
    ------
    DatabaseError
        If the classifier has other classes.
    RecordingError
        If a cloud is listed under two names, or the log cannot be written.
    CloudError
        If a cloud cannot be read or perceived; what was labelled before is in the log.

    Warns
    -----
    PoseWarning
        Once for each likely fault of the poses of some scans.
    """
    log = log or LabelLog()
    perception = Perception(recording.header.layout, classifier, config)
    keys = _perceive(
        recording, perception, partial(_labels, recording.folder, perception), log, workers, progress
    )
    known = log.positions()
    scans = [
        LabelledScan(
            scan.viewpoint,
            scan.true,
            scan.objects,
            tuple(position.label for position in known[key]),
            tuple(position.finding for position in known[key]),
            known[key][0].pose_fault,
        )
        for key, scan in zip(keys, recording.scans, strict=True)
    ]
    _warn([scan.pose_fault for scan in scans])
    return scans


def match_recording(
    recording: Recording,
    classifier: Classifier,
    config: PerceptionConfig | None = None,
    *,
    workers: int | None = None,
    progress: Progress | None = None,
    log: MatchLog | None = None,
) -> list[MatchedScan]:
    """Classify the scans of a recording, and keep all that the classifier returns.

    Parameters, raises and warns as `label_recording`.
    """
    log = log or MatchLog()
    perception = Perception(recording.header.layout, classifier, config)
    keys = _perceive(
        recording, perception, partial(_matches, recording.folder, perception), log, workers, progress
    )
    known = log.matches()
    _warn([known[key][0].pose_fault for key in keys])
    return [
        MatchedScan(scan.viewpoint, scan.true, scan.objects, known[key])
        for key, scan in zip(keys, recording.scans, strict=True)
    ]


def _perceive(
    recording: Recording,
    perception: Perception,
    task: Callable[[Piece], dict[str, Any]],
    log: KeyedLog,
    workers: int | None,
    progress: Progress | None,
) -> list[str]:
    """Write what `task` returns of every scan to the log; return the scans' keys."""
    check_classes(perception.classifier, recording.header.classes, "the recording's")
    keys = [_key(recording.folder, scan) for scan in recording.scans]
    files: dict[str, str] = {}
    for key, scan in zip(keys, recording.scans, strict=True):
        if files.setdefault(key, scan.file) != scan.file:
            raise RecordingError(
                f"{scan.file} and {files[key]} in {recording.folder} are one scan under two names, which "
                f"would count twice: delete one line of {MANIFEST}"
            )
    _warn_of_viewpoints(recording)
    pieces = list(zip(keys, recording.scans, strict=True))
    label_missing(task, pieces, lambda piece: [piece[0]], log, workers, progress)
    return keys


def _warn(faults: Sequence[PoseFault | None]) -> None:
    """Warn once for each kind of fault; there is one fault or None for each scan."""
    for text in fault_texts(faults_of(faults), len(faults)):
        warnings.warn(text, PoseWarning, stacklevel=3)


def _warn_of_viewpoints(recording: Recording) -> None:
    """Warn of files that name a pose of the camera, beside that of the manifest."""
    with_pose = [scan.file for scan in recording.scans if has_viewpoint(recording.folder / scan.file)]
    if with_pose:
        warnings.warn(
            f"{len(with_pose)} of {len(recording.scans)} clouds in {recording.folder}, the first is "
            f"{with_pose[0]}, have a VIEWPOINT, which is not used: their points are taken in the camera "
            f"frame, and the camera's pose from {MANIFEST}",
            FileWarning,
            stacklevel=4,
        )


def _key(folder: Path, scan: RecordedScan) -> str:
    """Return a hash of everything that the labels of a scan depend on."""
    content = b"".join(file.read_bytes() for file in files_of(folder / scan.file))
    return hashlib.sha256(content + scan.world_from_camera.tobytes()).hexdigest()


def _labels(folder: Path, perception: Perception, piece: Piece) -> PositionLabels:
    """Return the labels of one scan, and what was found."""
    return {piece[0]: tuple(map(PositionLabel.of, _perceived(folder, perception, piece[1])))}


def _matches(folder: Path, perception: Perception, piece: Piece) -> Matches:
    """Return the matches of one scan."""
    return {piece[0]: tuple(map(Seen.of, _perceived(folder, perception, piece[1])))}


def _perceived(folder: Path, perception: Perception, recorded: RecordedScan) -> list[Perceived]:
    points = read_cloud(folder / recorded.file)
    try:
        with counted_warnings():
            return perception(Scan(points, recorded.world_from_camera, stamp=0.0))
    except CloudError as reason:
        raise CloudError(f"{folder / recorded.file}: {reason}") from reason
