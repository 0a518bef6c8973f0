"""Training data in folders: the sub-folder that a file lies in names its class."""

import re
import warnings
from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

from beltsort.errors import DatabaseError
from beltsort.perception.checks import FileWarning

MESH_SUFFIXES = (".stl", ".obj", ".off", ".gltf", ".glb")
"""Of files that hold meshes and no clouds; a .ply file holds either."""

MOST_OF_A_HEADER = 4096  # bytes
FACES = re.compile(rb"^element face 0*[1-9]", re.MULTILINE)


@dataclass(frozen=True)
class OtherKind:
    """What a folder may hold instead of what was expected, and what to do then."""

    name: str
    expected: str
    remedy: str
    holds: Callable[[Path], bool]


def is_mesh(file: Path) -> bool:
    """Return whether a file holds a mesh, judged by its suffix, of a PLY file by the faces in its header."""
    suffix = file.suffix.lower()
    if suffix != ".ply":
        return suffix in MESH_SUFFIXES
    try:
        with file.open("rb") as opened:
            return FACES.search(opened.read(MOST_OF_A_HEADER)) is not None
    except OSError:
        return False


MESHES = OtherKind(
    "meshes",
    "point clouds",
    "train with `beltsort train --meshes`, in Python `beltsort.sim.meshes.train_from_meshes`",
    is_mesh,
)


@dataclass(frozen=True)
class Skipped:
    """What was not trained on, and why."""

    path: Path
    reason: str

    def __str__(self) -> str:
        """Return path and reason, which may begin with the path itself."""
        return f"skipped {self.path}: {self.reason.removeprefix(f'{self.path} ')}"


def training_files(folder: str | PathLike[str]) -> list[Path]:
    """Return every file of `folder` and of all folders in it, in a fixed order.

    Links to folders deeper than the classes are not followed; they are returned like files.

    Raises
    ------
    DatabaseError
        If there is no such folder, or no file in it.
    """
    root = Path(folder)
    if not root.is_dir():
        raise DatabaseError(f"{root} is no folder, expected one with a sub-folder for each class")
    children = sorted(root.iterdir())
    found = [file for child in children if child.is_dir() for file in sorted(child.rglob("*"))]
    found += [child for child in children if not child.is_dir()]
    files = [path for path in found if path.is_symlink() or not path.is_dir()]
    if not files:
        raise DatabaseError(f"{root} holds no file, expected some in a sub-folder for each class")
    return files


def warn_of_twins(files: Iterable[Path]) -> None:
    """Warn of files that differ in their suffix only: one object that counts twice, most likely."""
    twins: dict[Path, list[Path]] = defaultdict(list)
    for file in files:
        twins[file.with_suffix("")].append(file)
    for same in twins.values():
        if len(same) > 1:
            names = " and ".join(file.name for file in same)
            warnings.warn(
                f"{same[0].parent}: {names} have one name: if they show one object, it counts {len(same)} "
                "times; delete all but one, or rename them",
                FileWarning,
                stacklevel=3,
            )


def class_folder(file: Path, folder: str | PathLike[str]) -> str | None:
    """Return the name of the sub-folder of `folder` that `file` lies in, None if it lies in none."""
    first, *deeper = file.relative_to(folder).parts
    return first if deeper else None


def expect_two_classes(
    names: Iterable[str], folder: str | PathLike[str], skipped: Sequence[Skipped], other: OtherKind
) -> list[str]:
    """Return the distinct names in order.

    Raises
    ------
    DatabaseError
        If there are fewer than two, with the first reason why a file was skipped, or what to do with files
        of the other kind.
    """
    classes = sorted(set(names))
    if len(classes) >= 2:
        return classes
    found = f"{folder} gives training data of {len(classes)} classes {classes}, expected at least 2"
    if others := sum(other.holds(each.path) for each in skipped):
        raise DatabaseError(
            f"{found}: {others} of its files are {other.name}, expected {other.expected}; {other.remedy}"
        )
    first = [f"; {len(skipped)} skipped, the first: {s.path}: {s.reason}" for s in skipped[:1]]
    raise DatabaseError(
        f"{found}: put files that can be used into a sub-folder for each class{''.join(first)}"
    )
