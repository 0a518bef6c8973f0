"""Point clouds from files."""

import warnings
from collections.abc import Callable
from os import PathLike
from pathlib import Path

import numpy as np

from beltsort.errors import CloudError
from beltsort.geometry import Points
from beltsort.perception.checks import FileWarning
from beltsort.perception.formats.content import Content, UnreadableError
from beltsort.perception.formats.depth_image import camera_file, parse_depth
from beltsort.perception.formats.npy import parse_npy
from beltsort.perception.formats.pcd import parse_pcd, viewpoint_of
from beltsort.perception.formats.ply import parse_ply
from beltsort.perception.formats.text import parse_text

PARSERS: dict[str, Callable[[bytes], Content]] = {
    ".npy": parse_npy,
    ".pcd": parse_pcd,
    ".ply": parse_ply,
    ".xyz": parse_text,
    ".asc": parse_text,
    ".csv": parse_text,
    ".pts": parse_text,
    ".txt": parse_text,
}
DEPTH = ".png"
SUFFIXES = (*PARSERS, DEPTH)

FARTHEST = 1e12
"""Coordinates beyond it, which some sensors write for a pixel without return (FLT_MAX), are no numbers."""

MOST_OF_A_HEADER = 4096  # bytes

REMEDIES = {
    ".npz": "save its array of points with np.save",
    **dict.fromkeys((".stl", ".obj", ".off", ".gltf", ".glb"), "it is a mesh, for `beltsort train --meshes`"),
    **dict.fromkeys((".jpg", ".jpeg", ".tif", ".tiff", ".exr"), "save depth images as 16-bit PNG"),
}


def read_cloud(path: str | PathLike[str]) -> Points:
    """Read a point cloud.

    Parameters
    ----------
    path
        A .pcd or .ply file, text with one point a line (.xyz, .txt, .csv, .asc, .pts), a .npy file, or a
        depth image (16-bit .png) beside a JSON file of the camera's intrinsics.

    Returns
    -------
    Points
        Shape (n, 3), n > 0, in the file's unit and frame (depth images: metres, camera frame); NaN where the
        file has no number, or one beyond 1e12, as a pixel without return may be written.

    Raises
    ------
    CloudError
        If the file is missing, of another format, damaged, truncated, or holds no finite point.

    Warns
    -----
    FileWarning
        If the file holds more than is read: data behind its points, or the faces of a mesh.
    """
    return read_content(path).points


def read_content(path: str | PathLike[str]) -> Content:
    """Read a point cloud and what the file says of the camera; raises and warns as `read_cloud`."""
    file = Path(path)
    suffix = file.suffix.lower()
    if suffix not in SUFFIXES:
        remedy = REMEDIES.get(suffix, "convert the file")
        raise CloudError(f"{file} has suffix {file.suffix!r}, expected one of {[*SUFFIXES]}: {remedy}")
    remedy = f"expected a complete {suffix} file: write it again"
    try:
        data = file.read_bytes()
        content = parse_depth(data, file) if suffix == DEPTH else PARSERS[suffix](data)
    except OSError as reason:
        raise CloudError(f"cannot read {file}: {reason.strerror}; give the path of a file") from reason
    except UnreadableError as reason:
        raise CloudError(reason.message(file, remedy)) from reason
    except Exception as reason:  # whatever else a parser stumbles over means that the file is damaged
        raise CloudError(f"cannot read {file}: its content is damaged; {remedy}") from reason
    points = _without_far(content.points)
    if len(points) == 0:
        raise CloudError(f"{file} holds 0 points, expected at least one: scan again")
    finite = np.isfinite(points)
    if not finite.all() and not finite.all(axis=1).any():
        raise CloudError(
            f"{file} holds {len(points)} points, 0 of them finite, expected at least one: scan again"
        )
    _warn(file, content)
    return Content(points, content.camera, content.faces, content.notes)


def files_of(path: str | PathLike[str]) -> list[Path]:
    """Return the files that a cloud is read from: its own, and a depth image's intrinsics."""
    file = Path(path)
    intrinsics = camera_file(file) if file.suffix.lower() == DEPTH else None
    return [file] if intrinsics is None else [file, intrinsics]


def has_viewpoint(path: str | PathLike[str]) -> bool:
    """Return whether a file names a pose of the camera: a PCD file whose VIEWPOINT is not the identity."""
    file = Path(path)
    if file.suffix.lower() != ".pcd":
        return False
    with file.open("rb") as opened:
        return viewpoint_of(opened.read(MOST_OF_A_HEADER)) is not None


def _without_far(points: Points) -> Points:
    """Return the points with NaN for what no sensor can have measured."""
    with np.errstate(invalid="ignore"):
        far = np.abs(points) > FARTHEST
    if not far.any():
        return points
    near = points.copy()
    near[far] = np.nan
    return near


def _warn(file: Path, content: Content) -> None:
    for note in content.notes:
        warnings.warn(f"{file}: {note}", FileWarning, stacklevel=4)
    if content.faces:
        warnings.warn(
            f"{file} has {content.faces} faces, which are not read: if it is a mesh and no scan, train with "
            "`beltsort train --meshes`",
            FileWarning,
            stacklevel=4,
        )
