"""Label recorded scans."""

import hashlib
from functools import partial
from pathlib import Path

from beltsort.cell.protocols import Scan
from beltsort.errors import CloudError, DatabaseError, RecordingError
from beltsort.geometry import BeltLayout
from beltsort.perception import NearestNeighbour, Perception, read_cloud
from beltsort.tables.log import LabelLog, Labels, label_missing
from beltsort.tables.recording import MANIFEST, RecordedScan, Recording
from beltsort.tables.scans import LabelledScan
from beltsort.util.processes import Progress


def label_recording(
    recording: Recording,
    database: NearestNeighbour,
    *,
    workers: int | None = None,
    progress: Progress | None = None,
    log: LabelLog | None = None,
) -> list[LabelledScan]:
    """Label the scans of a recording.

    Parameters
    ----------
    recording
        The folder.
    database
        The classifier; its classes must be the recording's.
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
    """
    if database.classes != recording.header.classes:
        raise DatabaseError(
            f"the classifier's classes are {list(database.classes)}, expected the recording's "
            f"{list(recording.header.classes)}, in order: train one for these classes"
        )
    log = log or LabelLog()
    keys = [_key(recording.folder, scan) for scan in recording.scans]
    files: dict[str, str] = {}
    for key, scan in zip(keys, recording.scans, strict=True):
        if files.setdefault(key, scan.file) != scan.file:
            raise RecordingError(
                f"{scan.file} and {files[key]} in {recording.folder} are one scan under two names, which "
                f"would count twice: delete one line of {MANIFEST}"
            )
    label_missing(
        partial(_labelled, recording.folder, recording.header.layout, database),
        list(zip(keys, recording.scans, strict=True)),
        lambda piece: [piece[0]],
        log,
        workers,
        progress,
    )
    known = log.labels()
    return [
        LabelledScan(scan.viewpoint, scan.true, scan.objects, known[key])
        for key, scan in zip(keys, recording.scans, strict=True)
    ]


def _key(folder: Path, scan: RecordedScan) -> str:
    """Return a hash of everything that the labels of a scan depend on."""
    content = (folder / scan.file).read_bytes()
    return hashlib.sha256(content + scan.world_from_camera.tobytes()).hexdigest()


def _labelled(
    folder: Path, layout: BeltLayout, database: NearestNeighbour, piece: tuple[str, RecordedScan]
) -> Labels:
    """Return the labels of one scan."""
    key, recorded = piece
    points = read_cloud(folder / recorded.file)
    try:
        seen = Perception(layout, database)(Scan(points, recorded.world_from_camera, stamp=0.0))
    except CloudError as reason:
        raise CloudError(f"{folder / recorded.file}: {reason}") from reason
    return {key: tuple(position.label for position in seen)}
