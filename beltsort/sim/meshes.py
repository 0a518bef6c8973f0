"""Training of a classifier on meshes, by scans of the simulated cell."""

from collections.abc import Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

from beltsort.errors import CellError
from beltsort.perception import NearestNeighbour, PerceptionConfig
from beltsort.perception.clouds import SUFFIXES
from beltsort.perception.folders import (
    OtherKind,
    Skipped,
    class_folder,
    expect_two_classes,
    is_mesh,
    training_files,
    warn_of_twins,
)
from beltsort.perception.training import Trained
from beltsort.sim import CellConfig
from beltsort.sim.collect import training_views
from beltsort.sim.config import TRAINING_OBJECTS
from beltsort.util.processes import Progress

UNSEEN = "no scan shows enough of it above the rim of its cup: give a larger mesh, in metres"
"""Reason for skipping a mesh."""


CLOUDS = OtherKind(
    "point clouds",
    "meshes",
    "omit --meshes, in Python train with `beltsort.perception.train_from_clouds`",
    lambda file: file.suffix.lower() in SUFFIXES and not is_mesh(file),
)


@dataclass(frozen=True)
class MeshFolder:
    """The meshes of a folder, of two classes or more.

    Attributes
    ----------
    files
        The meshes.
    names
        The class of each.
    skipped
        Every other file of the folder.
    """

    files: tuple[Path, ...]
    names: tuple[str, ...]
    skipped: tuple[Skipped, ...]

    def cell(self) -> CellConfig:
        """Return the default simulated cell with these classes, sorted by name.

        Of several meshes of a class, one is drawn for each object.
        """
        of_class: dict[str, tuple[str, ...]] = dict.fromkeys(sorted(self.names), ())
        for file, name in zip(self.files, self.names, strict=True):
            of_class[name] += (str(file),)
        single = {name: files[0] if len(files) == 1 else files for name, files in of_class.items()}
        return CellConfig(classes=tuple(of_class), meshes=single)


def read_mesh_folder(folder: str | PathLike[str]) -> MeshFolder:
    """Find the meshes in a folder and their classes, as `train_from_meshes` does; raises and warns alike."""
    files, skipped = _readable(training_files(folder))
    warn_of_twins(files)
    names = [class_folder(file, folder) or file.stem for file in files]
    expect_two_classes(names, folder, skipped, CLOUDS)
    return MeshFolder(tuple(files), tuple(names), tuple(skipped))


def train_from_meshes(
    folder: str | PathLike[str],
    perception: PerceptionConfig | None = None,
    *,
    objects: int = TRAINING_OBJECTS,
    seed: int = 0,
    workers: int | None = None,
    distance: str = "chi2",
    k: int = 1,
    progress: Progress | None = None,
) -> Trained:
    """Train on scans of the meshes in a folder, simulated in the default simulated cell.

    As with `collect_training`, a script must call this under `if __name__ == "__main__":`.

    Parameters
    ----------
    folder
        Folder of meshes (PLY, STL, OBJ, OFF, glTF; metres, axis along z). The class of a mesh is the name of
        its sub-folder; a mesh that is not in a sub-folder is a class of its own, with the file's name.
    perception
        Settings; default `PerceptionConfig()`.
    objects
        Objects of each mesh at each viewpoint and position, each with a size and pose of its own.
    seed, workers, progress
        As in `collect_training`.
    distance, k
        As in `NearestNeighbour`.

    Raises
    ------
    ArgumentError
        If `objects` or `workers` is below 1.
    DatabaseError
        If the folder does not exist, fewer than two classes have a usable mesh, or a setting is invalid.
    BeltsortError
        If a worker process dies.

    Warns
    -----
    FileWarning
        As `read_mesh`, and about meshes that differ in their suffix only.
    """
    meshes = read_mesh_folder(folder)
    perception = perception or PerceptionConfig()
    single = {str(file): str(file) for file in meshes.files}  # a class for each mesh
    scanned = training_views(
        CellConfig(classes=tuple(single), meshes=single),
        perception,
        objects=objects,
        seed=seed,
        workers=workers,
        progress=progress,
    )
    found = sorted(set(scanned.labels))
    unseen = [Skipped(file, UNSEEN) for label, file in enumerate(meshes.files) if label not in found]
    skipped = [*meshes.skipped, *unseen]
    entries = [meshes.names[label] for label in scanned.labels]
    classes = expect_two_classes(entries, folder, skipped, CLOUDS)
    labels = [classes.index(name) for name in entries]
    database = NearestNeighbour.train(
        scanned.descriptors, labels, classes, perception, distance=distance, k=k
    )
    files = tuple(meshes.files[label] for label in found)
    return Trained(database, files, tuple(skipped), missed=dict(scanned.missed))


def _readable(files: Sequence[Path]) -> tuple[list[Path], list[Skipped]]:
    from beltsort.sim.surfaces import read_mesh

    meshes, skipped = [], []
    for file in files:
        try:
            read_mesh(file)
        except CellError as reason:
            skipped.append(Skipped(file, str(reason)))
        else:
            meshes.append(file)
    return meshes, skipped
