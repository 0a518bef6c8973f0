"""The latest scans of a run, thinned out, for whoever watches: files of bounded number and size.

They are no part of the run's record: they are not synchronised with the disk, and a run continues without
them. Each is a file of its own, named by its journal entry and complete once it has that name, so that a
killed process leaves the others, and readers see none that is half written.
"""

import io
import os
import warnings
import zipfile
import zlib
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from beltsort.cell import Cell, Scan
from beltsort.cell.arrival import viewpoint_poses
from beltsort.errors import JournalError
from beltsort.geometry import BeltLayout, Points, Pose, transform
from beltsort.sorting.journal import Entry
from beltsort.sorting.perceived import PerceivedPosition

SCANS = "scans"
"""The folder of the kept scans, in that of the run."""
SURROUNDINGS, CANDIDATE = 4000, 900
"""Numbers of points kept: of the surroundings, and of each candidate."""
MILLIMETRES = 1000.0
"""In a metre; files have points in whole millimetres."""
MARGIN = 0.15
"""How far around the belt positions points are kept, metres."""

UNFINISHED = ".new-"
"""In the name of a file until it is complete."""

ScanListener = Callable[[Entry, Scan, Sequence[PerceivedPosition]], None]
"""Called with the entry of a scan, the scan, and what was perceived in it, after the entry was written."""


def all_of(*listeners: ScanListener | None) -> ScanListener:
    """Return a listener that calls others in order; None is left out."""

    def listen(entry: Entry, scan: Scan, perceived: Sequence[PerceivedPosition]) -> None:
        for listener in listeners:
            if listener is not None:
                listener(entry, scan, perceived)

    return listen


@runtime_checkable
class TellsCandidate(Protocol):
    """A perceived position that tells which points are its object's."""

    @property
    def points(self) -> Points | None:
        """The candidate, shape (n, 3), belt frame, metres; None if there is none."""


@dataclass(frozen=True, eq=False)
class KeptScan:
    """A scan, thinned out; frames are the belt's, lengths metres, points rounded to millimetres by `save`.

    Attributes
    ----------
    entry
        Number of its journal entry.
    points
        float32 of shape (n, 3).
    positions
        The belt position whose candidate each point belongs to, int16 of shape (n,); -1 for none.
    camera
        `world_from_camera`, shape (4, 4).
    viewpoints
        The camera's pose at each viewpoint, shape (K, 4, 4); NaN where it is not known.
    layout
        The belt's.
    """

    entry: int
    points: NDArray[np.float32]
    positions: NDArray[np.int16]
    camera: Pose
    viewpoints: NDArray[np.float64]
    layout: BeltLayout

    def save(self, path: Path) -> None:
        """Write the file; one that is there is replaced at once.

        Raises
        ------
        OSError
            If it cannot be written; the former one is then still there.
        """
        content = io.BytesIO()
        layout = {f"layout_{name}": value for name, value in asdict(self.layout).items()}
        whole, limits = np.rint(MILLIMETRES * self.points), np.iinfo(np.int16)
        np.savez_compressed(
            content,
            entry=self.entry,
            millimetres=whole.clip(limits.min, limits.max).astype(np.int16),
            positions=self.positions,
            camera=self.camera,
            viewpoints=self.viewpoints,
            **layout,
        )
        fresh = path.with_name(f"{path.name}{UNFINISHED}{os.getpid()}")
        try:
            fresh.write_bytes(content.getbuffer())
            fresh.replace(path)
        except OSError:
            fresh.unlink(missing_ok=True)
            raise

    @classmethod
    def load(cls, path: Path) -> "KeptScan":
        """Read a file that `save` wrote.

        Raises
        ------
        JournalError
            If it is missing or damaged.
        """
        try:
            with np.load(path) as data:
                layout = {name: data[f"layout_{name}"].item() for name in BeltLayout.__dataclass_fields__}
                return cls(
                    int(data["entry"]),
                    points=(data["millimetres"] / MILLIMETRES).astype(np.float32),
                    positions=data["positions"],
                    camera=data["camera"],
                    viewpoints=data["viewpoints"],
                    layout=BeltLayout(**layout),
                )
        except (OSError, EOFError, ValueError, KeyError, zipfile.BadZipFile, zlib.error) as reason:
            raise JournalError(
                f"{path} cannot be read as a scan that a run keeps: {reason}; delete it, no run needs it"
            ) from reason


class ScanKeeper:
    """A `ScanListener` that keeps the latest scans in a folder.

    A scan that cannot be written is left out, with a warning the first time; the next one may find room.

    Parameters
    ----------
    run
        The run's folder; the scans are in a folder in it, together with those of the run before it was
        resumed.
    cell
        Tells layout and poses of the viewpoints.
    keep
        Number of scans to keep; 0 for none.
    """

    def __init__(self, run: Path, cell: Cell, keep: int) -> None:
        self._run, self._keep, self._layout = run, keep, cell.layout
        self._kept = deque(kept_scans(run))
        self._begun = self._warned = False
        unknown = np.full((4, 4), np.nan)
        poses = [unknown if pose is None else pose for pose in viewpoint_poses(cell)]
        self._viewpoints = np.array(poses, dtype=np.float64).reshape(-1, 4, 4)

    def __call__(self, entry: Entry, scan: Scan, perceived: Sequence[PerceivedPosition]) -> None:
        """Keep a scan, and drop the oldest ones."""
        if self._keep < 1:
            return
        points, positions = thinned(scan, perceived, self._layout)
        kept = KeptScan(
            entry.number, points, positions, scan.world_from_camera, self._viewpoints, self._layout
        )
        try:
            self._begin()
            kept.save(scan_file(self._run, entry.number))
            self._kept.append(entry.number)
            while len(self._kept) > self._keep:
                scan_file(self._run, self._kept[0]).unlink(missing_ok=True)
                self._kept.popleft()
        except OSError as reason:
            if not self._warned:
                self._warned = True
                warnings.warn(
                    f"the scan cannot be kept in {self._run / SCANS} ({reason}): the run goes on, and "
                    "`beltsort watch` does not show its cloud; make room, or set kept_scans of [rules] lower",
                    stacklevel=2,
                )

    def _begin(self) -> None:
        """Make the folder, without what a process left that was killed while it wrote."""
        if not self._begun:
            folder = self._run / SCANS
            folder.mkdir(exist_ok=True)
            for unfinished in folder.glob(f"*{UNFINISHED}*"):
                unfinished.unlink(missing_ok=True)
            self._begun = True


def scan_file(run: Path, entry: int) -> Path:
    """Return the file of a kept scan: in the run's folder, by the number of its journal entry."""
    return run / SCANS / f"{entry:09d}.npz"


def kept_scans(run: Path) -> list[int]:
    """Return the numbers of the journal entries of the scans that are kept in a run's folder, in order."""
    return sorted(int(file.stem) for file in (run / SCANS).glob("*.npz") if file.stem.isdecimal())


def thinned(
    scan: Scan, perceived: Sequence[PerceivedPosition], layout: BeltLayout
) -> tuple[NDArray[np.float32], NDArray[np.int16]]:
    """Return a bounded number of a scan's points near the belt positions, candidates in particular.

    Returns
    -------
    points
        Belt frame, metres, float32 of shape (n, 3).
    positions
        The position whose candidate each belongs to, -1 for none, int16 of shape (n,).
    """
    points = scan.points.reshape(-1, 3)
    points = transform(scan.world_from_camera, points[:: 1 + len(points) // (8 * SURROUNDINGS)])
    first, last = layout.centre(0) - MARGIN, layout.centre(layout.positions - 1) + MARGIN
    last[2] = layout.crop_height
    with np.errstate(invalid="ignore"):
        near = ((points >= first) & (points <= last)).all(axis=1)  # False where there was no return
    parts = [_at_most(SURROUNDINGS, points[near])]
    of = [-1]
    for position, seen in enumerate(perceived):
        if isinstance(seen, TellsCandidate) and seen.points is not None:
            parts.append(_at_most(CANDIDATE, seen.points))
            of.append(position)
    numbers = np.repeat(np.array(of, dtype=np.int16), [len(part) for part in parts])
    return np.concatenate(parts).astype(np.float32), numbers


def _at_most(count: int, points: Points) -> Points:
    """Return at most `count` of the points, evenly spread over their order."""
    if len(points) <= count:
        return points
    return points[np.linspace(0, len(points) - 1, count).astype(np.intp)]
