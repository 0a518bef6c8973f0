"""Positions of the camera that recorded clouds of single objects."""

import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path

import numpy as np

from beltsort.errors import CloudError
from beltsort.geometry import Points
from beltsort.perception.checks import FileWarning
from beltsort.perception.formats.content import UnreadableError
from beltsort.perception.formats.lines import Line, is_number, lines_of


@dataclass(frozen=True)
class CameraPositions:
    """Where the camera stood, in the frame of each cloud.

    Attributes
    ----------
    everywhere
        Of every cloud, shape (3,), metres; None: as the file of the cloud says (VIEWPOINT of a PCD file whose
        points are in the world frame), otherwise the origin.
    by_file
        Of the clouds of some files, by their resolved paths.
    """

    everywhere: Points | None = None
    by_file: Mapping[Path, Points] = field(default_factory=dict)

    def __repr__(self) -> str:
        """Return the position of all clouds, and how many files have another."""
        everywhere = None if self.everywhere is None else self.everywhere.tolist()
        return f"CameraPositions(everywhere={everywhere}, by_file=<{len(self.by_file)} files>)"

    def of(self, file: Path, recorded: Points | None) -> Points:
        """Return the position for the cloud in `file`, shape (3,).

        Parameters
        ----------
        file
            The file.
        recorded
            The position that the file itself names, or None.

        Raises
        ------
        CloudError
            If there are positions of other files only.

        Warns
        -----
        FileWarning
            If the file names another position than the one returned.
        """
        given = self.by_file.get(file.resolve(), self.everywhere)
        if given is None and recorded is None and self.by_file:
            raise CloudError(f"{file} has no camera position: add a line to the file of positions")
        if given is None:
            return np.zeros(3) if recorded is None else recorded
        if recorded is not None and not np.allclose(given, recorded):
            warnings.warn(
                f"{file}: its own VIEWPOINT ({_words(recorded)}) is not used, but what is given "
                f"({_words(given)})",
                FileWarning,
                stacklevel=3,
            )
        return given


def _words(position: Points) -> str:
    return " ".join(f"{value:g}" for value in np.ravel(position))


def read_camera_positions(path: str | PathLike[str]) -> CameraPositions:
    """Read the camera's position for each of many clouds from a text file.

    Each line has the path of a cloud, which starts at the file's folder, and x, y and z in metres, separated
    by commas, tabs or blanks; a first line with names of columns and lines that start with # are skipped.

    Raises
    ------
    CloudError
        If the file is missing, or a line is not understood.
    """
    file = Path(path)
    try:
        lines = lines_of(file.read_text("utf-8-sig"))
    except (OSError, UnicodeDecodeError) as reason:
        raise CloudError(
            f"cannot read {file}; expected a text file with path, x, y and z of a cloud in each line"
        ) from reason
    positions = {}
    rows = [line for line in lines if not line.text.startswith("#")]
    for row in rows[1:] if rows and _is_title(rows[0]) else rows:
        cloud, position = _row(file, row)
        positions[(file.parent / cloud).resolve()] = position
    if not positions:
        raise CloudError(f"{file} has 0 camera positions, expected path, x, y and z of a cloud in each line")
    return CameraPositions(by_file=positions)


def _is_title(line: Line) -> bool:
    return not is_number(_words_of(line)[-1])


def _words_of(line: Line) -> list[str]:
    separator = next((mark for mark in ",;\t" if mark in line.text), None)
    return [word.strip() for word in line.text.rsplit(separator, 3)]


def _row(file: Path, line: Line) -> tuple[str, Points]:
    cloud, *words = _words_of(line)
    position = np.array([float(word) for word in words if is_number(word)])
    if position.shape != (3,) or len(words) != 3 or not np.isfinite(position).all():
        problem = f"{line.text[:60]!r} is no path with three finite numbers"
        raise CloudError(UnreadableError(problem, line=line.number).message(file, "correct the line"))
    return cloud, position
