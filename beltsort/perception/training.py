"""A database from folders of clouds."""

from dataclasses import dataclass
from os import PathLike
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from beltsort.errors import CloudError
from beltsort.geometry import Points
from beltsort.perception.clean import voxel_means
from beltsort.perception.clouds import read_cloud
from beltsort.perception.config import PerceptionConfig
from beltsort.perception.descriptor import describe
from beltsort.perception.folders import Skipped, class_folder, expect_two_classes, training_files
from beltsort.perception.nearest import NearestNeighbour
from beltsort.perception.vfh import Histogram

LARGEST_OBJECT = 2.0  # metres; a cloud beyond it is in other units, or a whole scene


@dataclass(frozen=True, eq=False)
class Trained:
    """A database and the files it was trained on.

    Attributes
    ----------
    database
        The database.
    files
        The files that were trained on.
    skipped
        Every other file of the folder.
    """

    database: NearestNeighbour
    files: tuple[Path, ...]
    skipped: tuple[Skipped, ...]


def read_candidate(path: str | PathLike[str], config: PerceptionConfig) -> Points:
    """Read the cloud of one object and thin it out as `segment` does, shape (n, 3).

    Points that are not finite are dropped. The VIEWPOINT of a PCD file is not used: writers disagree on
    whether the points beside it are given in the camera's frame or in the world's.

    Parameters
    ----------
    path
        A file that `read_cloud` reads, metres.
    config
        Of the database that the candidate is for.

    Raises
    ------
    CloudError
        If the file cannot be read, shows too little to be labelled, or more than an object.
    """
    points = read_cloud(path)
    finite = points[np.isfinite(points).all(axis=1)]
    extent = np.ptp(finite, axis=0).max() if len(finite) else 0.0
    if extent > LARGEST_OBJECT:
        raise CloudError(
            f"the cloud extends over {extent:g} m, expected an object of at most {LARGEST_OBJECT:g} m: give "
            "coordinates in metres, and nothing but the object"
        )
    candidate = voxel_means(finite, config.voxel)
    if len(candidate) < config.fewest_labelled:
        raise CloudError(
            f"{len(points)} points in {len(candidate)} voxels of {config.voxel:g} m, expected at least "
            f"{config.fewest_labelled} voxels: give coordinates in metres, or scan from closer"
        )
    return candidate


def train_from_clouds(
    folder: str | PathLike[str],
    config: PerceptionConfig | None = None,
    *,
    viewpoint: ArrayLike = (0.0, 0.0, 0.0),
    distance: str = "chi2",
    k: int = 1,
) -> Trained:
    """Train on a folder with one sub-folder of object clouds for each class.

    Parameters
    ----------
    folder
        The .pcd, .ply, .xyz and .npy files in a sub-folder, however deep, are of the class that it is named
        after; each is the cloud of one object, metres.
    config
        Settings; default `PerceptionConfig()`.
    viewpoint
        The camera's position in the frame of every cloud, shape (3,), metres.
    distance, k
        As in `NearestNeighbour`.

    Raises
    ------
    DatabaseError
        If there is no such folder, fewer than two classes have a cloud that can be used, or a setting is
        out of range.
    """
    config = config or PerceptionConfig()
    rows: list[Histogram] = []
    names: list[str] = []
    files, skipped = [], []
    for file in training_files(folder):
        try:
            name = class_folder(file, folder)
            if name is None:
                raise CloudError(
                    "it lies in no sub-folder, expected one for each class: move it into its class's"
                )
            rows.append(describe(read_candidate(file, config), viewpoint, config))
        except CloudError as reason:
            skipped.append(Skipped(file, str(reason)))
        else:
            names.append(name)
            files.append(file)
    classes = expect_two_classes(names, folder, skipped)
    labels = [classes.index(name) for name in names]
    database = NearestNeighbour.train(rows, labels, classes, config, distance=distance, k=k)
    return Trained(database, tuple(files), tuple(skipped))
