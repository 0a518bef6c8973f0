"""Training data in folders: the sub-folder that a file lies in names its class."""

import warnings
from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

from beltsort.errors import DatabaseError
from beltsort.perception.checks import FileWarning


@dataclass(frozen=True)
class Skipped:
    """What was not trained on, and why."""

    path: Path
    reason: str


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
    names: Iterable[str], folder: str | PathLike[str], skipped: Sequence[Skipped]
) -> list[str]:
    """Return the distinct names in order.

    Raises
    ------
    DatabaseError
        If there are fewer than two, with the first reason why a file was skipped.
    """
    classes = sorted(set(names))
    if len(classes) < 2:
        first = [f"; {len(skipped)} skipped, the first: {s.path}: {s.reason}" for s in skipped[:1]]
        raise DatabaseError(
            f"{folder} gives training data of {len(classes)} classes {classes}, expected at least 2: "
            f"put files that can be used into a sub-folder for each class{''.join(first)}"
        )
    return classes
