"""A database from folders of clouds."""

import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from beltsort.errors import CloudError
from beltsort.geometry import Points
from beltsort.perception.cameras import CameraPositions
from beltsort.perception.checks import FileWarning, as_array
from beltsort.perception.clean import voxel_means
from beltsort.perception.clouds import files_of, read_cloud, read_content
from beltsort.perception.config import PerceptionConfig
from beltsort.perception.descriptor import describe
from beltsort.perception.finding import Finding
from beltsort.perception.folders import (
    MESHES,
    Skipped,
    class_folder,
    expect_two_classes,
    training_files,
    warn_of_twins,
)
from beltsort.perception.nearest import NearestNeighbour
from beltsort.perception.vfh import Histogram

LARGEST_OBJECT = 2.0  # metres; a cloud beyond it is in other units, or a whole scene
FARTHEST_CAMERA = 20.0  # metres; beyond it, the position of the camera is unknown, most likely


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
        Every other file of the folder, but for the intrinsics of depth images.
    own_viewpoints
        Number of files whose own VIEWPOINT was the camera's position.
    missed
        Of meshes: how often something else was found where an object was scanned, so that it gave no entry.
    """

    database: NearestNeighbour
    files: tuple[Path, ...]
    skipped: tuple[Skipped, ...]
    own_viewpoints: int = 0
    missed: Mapping[Finding, int] = field(default_factory=dict)

    def __repr__(self) -> str:
        """Return what the database holds, and how many files were used."""
        return f"Trained({self.database!r}, {len(self.files)} files used, {len(self.skipped)} skipped)"


class View(NamedTuple):
    """A scan of one object.

    Attributes
    ----------
    points
        The candidate, shape (n, 3), metres.
    camera
        The camera's position in the frame of the points, shape (3,).
    own_viewpoint
        Whether the file itself gave that position.
    """

    points: Points
    camera: Points
    own_viewpoint: bool


def camera_positions(given: ArrayLike | CameraPositions | None) -> CameraPositions:
    """Return positions of the camera given as such, as one for all clouds, shape (3,), or not at all."""
    if given is None or isinstance(given, CameraPositions):
        return given or CameraPositions()
    return CameraPositions(as_array("viewpoint", given, CloudError))


def read_view(path: str | PathLike[str], config: PerceptionConfig, positions: CameraPositions) -> View:
    """Read the cloud of one object and where the camera stood.

    Parameters
    ----------
    path, config
        As in `read_candidate`.
    positions
        Where the camera stood.

    Raises
    ------
    CloudError
        As `read_candidate`, or if the camera's position is not known.

    Warns
    -----
    FileWarning
        As `read_cloud`, if the file's own VIEWPOINT is not used, and if the camera is far away.
    """
    content = read_content(path)
    camera = positions.of(Path(path), content.camera)
    candidate = as_candidate(content.points, config)
    distance = float(np.linalg.norm(candidate.mean(axis=0) - camera)) if camera.shape == (3,) else 0.0
    if distance > FARTHEST_CAMERA:
        warnings.warn(
            f"{path}: the object is {distance:.4g} m from the camera, expected at most {FARTHEST_CAMERA:g} "
            "m: if its points are in a world frame, give the camera's position (--viewpoint)",
            FileWarning,
            stacklevel=2,
        )
    return View(candidate, camera, camera is content.camera)


def read_candidate(path: str | PathLike[str], config: PerceptionConfig) -> Points:
    """Read the cloud of one object and thin it out as `segment` does, shape (n, 3).

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
    return as_candidate(read_cloud(path), config)


def as_candidate(points: Points, config: PerceptionConfig) -> Points:
    """Thin out the cloud of one object, shape (n, 3), as `segment` does.

    Points that are not finite are dropped.

    Raises
    ------
    CloudError
        If it shows too little to be labelled, or more than an object.
    """
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
    viewpoint: ArrayLike | CameraPositions | None = None,
    distance: str = "chi2",
    k: int = 1,
) -> Trained:
    """Train on a folder with one sub-folder of object clouds for each class.

    Parameters
    ----------
    folder
        The files that `read_cloud` reads in a sub-folder, however deep, are of the class that it is named
        after; each is the cloud of one object, metres.
    config
        Settings; default `PerceptionConfig()`.
    viewpoint
        The camera's position in the frame of every cloud, shape (3,), metres, or positions by file; default:
        where the VIEWPOINT of a PCD file says, otherwise the origin.
    distance, k
        As in `NearestNeighbour`.

    Raises
    ------
    DatabaseError
        If there is no such folder, fewer than two classes have a cloud that can be used, or a setting is
        out of range.

    Warns
    -----
    FileWarning
        As `read_view`, and about files that differ in their suffix only.
    """
    config = config or PerceptionConfig()
    positions = camera_positions(viewpoint)
    rows: list[Histogram] = []
    names: list[str] = []
    files, skipped = [], []
    given = training_files(folder)
    intrinsics = {other for file in given for other in files_of(file)[1:]}
    own = 0
    for file in given:
        if file in intrinsics:
            continue
        try:
            name = class_folder(file, folder)
            if name is None:
                raise CloudError(
                    "it lies in no sub-folder, expected one for each class: move it into its class's"
                )
            seen = read_view(file, config, positions)
            rows.append(describe(seen.points, seen.camera, config))
        except CloudError as reason:
            skipped.append(Skipped(file, str(reason)))
        else:
            names.append(name)
            files.append(file)
            own += seen.own_viewpoint
    warn_of_twins(files)
    classes = expect_two_classes(names, folder, skipped, MESHES)
    labels = [classes.index(name) for name in names]
    database = NearestNeighbour.train(rows, labels, classes, config, distance=distance, k=k)
    return Trained(database, tuple(files), tuple(skipped), own)
