"""Training of a classifier on meshes, by scans of the simulated cell."""

from collections.abc import Sequence
from os import PathLike
from pathlib import Path

from beltsort.errors import CellError
from beltsort.perception import NearestNeighbour, PerceptionConfig
from beltsort.perception.folders import (
    Skipped,
    class_folder,
    expect_two_classes,
    training_files,
    warn_of_twins,
)
from beltsort.perception.training import Trained
from beltsort.sim import CellConfig
from beltsort.sim.collect import collect_training
from beltsort.sim.config import TRAINING_OBJECTS
from beltsort.util.processes import Progress

UNSEEN = "no scan shows enough of it above the rim of its cup: give a larger mesh, in metres"
"""Reason for skipping a mesh."""


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
    meshes, skipped = _readable(training_files(folder))
    warn_of_twins(meshes)
    names = [class_folder(mesh, folder) or mesh.stem for mesh in meshes]
    expect_two_classes(names, folder, skipped)
    cell = CellConfig(
        classes=tuple(str(mesh) for mesh in meshes), meshes={str(mesh): str(mesh) for mesh in meshes}
    )
    scanned = collect_training(
        cell, perception, objects=objects, seed=seed, workers=workers, progress=progress
    )
    found = set(scanned.labels.tolist())
    skipped += [Skipped(mesh, UNSEEN) for label, mesh in enumerate(meshes) if label not in found]
    entries = [names[label] for label in scanned.labels]
    classes = expect_two_classes(entries, folder, skipped)
    labels = [classes.index(name) for name in entries]
    database = NearestNeighbour.train(
        scanned.descriptors, labels, classes, scanned.config, distance=distance, k=k
    )
    return Trained(database, tuple(meshes[label] for label in sorted(found)), tuple(skipped))


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
