"""Recording of simulated scans."""

import json
import os
from collections.abc import Iterable
from dataclasses import asdict, fields
from functools import partial
from pathlib import Path
from typing import Self

import numpy as np

from beltsort.errors import RecordingError
from beltsort.geometry import Points
from beltsort.sim import CellConfig
from beltsort.sim.collect import SCANS, table_scenes
from beltsort.sim.config import TABLE_OBJECTS
from beltsort.sim.rounds import Scenes
from beltsort.tables.recording import (
    HEADER,
    MANIFEST,
    Header,
    RecordedScan,
    Recording,
    read_header,
    read_manifest,
    read_recording,
)
from beltsort.util.processes import Progress, in_processes


class RecordingWriter:
    """Appends scans to a new or existing recording.

    A scan's cloud is written before its line in the manifest, so an interrupted recording is valid and lacks
    only its last scans.

    Parameters
    ----------
    folder
        Folder of the recording, created if it is missing.
    header
        Properties of all scans; an existing recording must have the same.

    Raises
    ------
    RecordingError
        If the folder cannot be written, or contains another recording.
    """

    def __init__(self, folder: Path, header: Header) -> None:
        self.folder, self.header = folder, header
        try:
            folder.mkdir(parents=True, exist_ok=True)
            if not (folder / HEADER).exists():
                _write_whole(folder / HEADER, header.to_json().encode())
            self._manifest = (folder / MANIFEST).open("ab+")
            self._drop_torn_line()
        except OSError as reason:
            raise RecordingError(
                f"the recording {folder} cannot be written: {reason}; name another folder"
            ) from reason
        there = read_header(folder)
        differing = [f.name for f in fields(Header) if getattr(there, f.name) != getattr(header, f.name)]
        if differing:
            self._manifest.close()
            raise RecordingError(
                f"{folder / HEADER} describes other scans, expected the same {', '.join(differing)}: name "
                "another folder"
            )

    def files(self) -> set[str]:
        """Return the files listed in the manifest."""
        return {scan.file for scan in read_manifest(self.folder, self.header)}

    def append(self, scans: Iterable[RecordedScan]) -> None:
        """Add scans whose clouds are written to the manifest, durably."""
        self._manifest.write("".join(scan.line(self.header) for scan in scans).encode())
        self._manifest.flush()
        os.fsync(self._manifest.fileno())

    def __enter__(self) -> Self:
        """Use the writer as a context that closes the manifest."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close the manifest."""
        self._manifest.close()

    def _drop_torn_line(self) -> None:
        """Remove an incomplete last line, left by an interrupted writer."""
        self._manifest.seek(0)
        content = self._manifest.read()
        self._manifest.truncate(content.rfind(b"\n") + 1)


def record_simulated(
    folder: Path,
    config: CellConfig | None = None,
    *,
    objects: int = TABLE_OBJECTS,
    seed: int = 0,
    passages: bool = False,
    workers: int | None = None,
    progress: Progress | None = None,
) -> Recording:
    """Record the scans that `collect_scans` labels: whole depth images, 7 MB each.

    Parameters
    ----------
    folder
        Folder of the recording; an interrupted one is resumed.
    config, objects, seed, workers, progress
        As in `collect_counts`.
    passages
        As in `beltsort.sim.collect.table_scenes`.

    Raises
    ------
    RecordingError
        If the folder cannot be written or holds another recording.
    ArgumentError, BeltsortError
        As `collect_counts`.
    """
    config = config or CellConfig()
    scenes = table_scenes(config, objects=objects, seed=seed, passages=passages)
    settings = json.loads(json.dumps(asdict(config)))
    viewpoints = tuple(viewpoint.name for viewpoint in config.viewpoints)
    source = {"cell": "simulated", "seed": seed, "settings": settings}
    with RecordingWriter(folder, Header(config.classes, viewpoints, config.layout, source)) as writer:
        known = writer.files()
        waiting = [work for work in scenes if not known >= set(_files(work, config))]
        for scans in in_processes(partial(_recorded, folder, config), waiting, workers, progress):
            writer.append(scan for scan in scans if scan.file not in known)
    return read_recording(folder)


def _files(work: Scenes, config: CellConfig) -> list[str]:
    return [f"{name}.npy" for name in work.scan_names(config, SCANS)]


def _recorded(folder: Path, config: CellConfig, work: Scenes) -> list[RecordedScan]:
    """Write the clouds of all scans."""
    files, recorded = iter(_files(work, config)), []
    for truth, scans in zip(work.truths(config), work.scans(config, SCANS), strict=True):
        for scan in scans:
            file = next(files)
            _write_cloud(folder / file, scan.points)
            pose = scan.world_from_camera
            recorded.append(RecordedScan(file, truth.viewpoint, truth.true, truth.objects, pose))
    return recorded


def _write_cloud(path: Path, points: Points) -> None:
    half_done = path.with_suffix(".part")
    with half_done.open("wb") as file:
        np.save(file, points, allow_pickle=False)
        file.flush()
        os.fsync(file.fileno())
    half_done.replace(path)


def _write_whole(path: Path, content: bytes) -> None:
    half_done = path.with_suffix(".part")
    half_done.write_bytes(content)
    half_done.replace(path)
