"""The last scan of a run, thinned out, for whoever watches: one file of bounded size that is replaced.

It is not part of the run's record: it is not synchronised with the disk, and a run continues without it.
"""

import io
import os
import zipfile
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

LAST_SCAN = "last-scan.npz"
SURROUNDINGS, CANDIDATE = 4000, 900
"""Numbers of points kept: of the surroundings, and of each candidate."""
MARGIN = 0.15
"""How far around the belt positions points are kept, metres."""

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
    """A scan, thinned out; frames are the belt's, lengths metres.

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
        np.savez(
            content,
            entry=self.entry,
            points=self.points,
            positions=self.positions,
            camera=self.camera,
            viewpoints=self.viewpoints,
            **layout,
        )
        fresh = path.with_name(f"{path.name}.new-{os.getpid()}")
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
                    points=data["points"],
                    positions=data["positions"],
                    camera=data["camera"],
                    viewpoints=data["viewpoints"],
                    layout=BeltLayout(**layout),
                )
        except (OSError, ValueError, KeyError, zipfile.BadZipFile) as reason:
            raise JournalError(
                f"{path} cannot be read as the last scan of a run: {reason}; the next scan replaces it"
            ) from reason


class ScanKeeper:
    """A `ScanListener` that keeps the last scan in a file. A full disk does not stop it.

    Parameters
    ----------
    path
        The file.
    cell
        Tells layout and poses of the viewpoints.
    """

    def __init__(self, path: Path, cell: Cell) -> None:
        self._path, self._layout = path, cell.layout
        unknown = np.full((4, 4), np.nan)
        poses = [unknown if pose is None else pose for pose in viewpoint_poses(cell)]
        self._viewpoints = np.array(poses, dtype=np.float64).reshape(-1, 4, 4)

    def __call__(self, entry: Entry, scan: Scan, perceived: Sequence[PerceivedPosition]) -> None:
        """Replace the file."""
        points, positions = thinned(scan, perceived, self._layout)
        kept = KeptScan(
            entry.number, points, positions, scan.world_from_camera, self._viewpoints, self._layout
        )
        try:
            kept.save(self._path)
        except OSError:
            return  # the next scan may find room


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
