"""Depth images: 16-bit PNG files beside a JSON file of the camera's intrinsics."""

import json
from collections.abc import Iterator, Mapping
from io import BytesIO
from math import isfinite
from pathlib import Path
from typing import NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from beltsort.errors import CloudError
from beltsort.perception.depth import MILLIMETRES, Intrinsics, cloud_from_depth
from beltsort.perception.formats.content import Content, UnreadableError
from beltsort.util.extras import extra

NAMES = ("scene_camera.json", "camera.json", "intrinsics.json", "camera_intrinsics.json", "camera_info.json")
"""Names of files of intrinsics, also in the folder above that of the image."""
MOST_COMPRESSED = 1040
"""Bytes of an image for one in its file, at most: DEFLATE's limit is 1032."""
WHAT_TO_DO = "write camera.json beside it, with fx, fy, cx, cy (pixels) and depth_scale (units per metre)"

Json = Mapping[str, object]


class Camera(NamedTuple):
    """What a file says of the depth camera.

    Attributes
    ----------
    intrinsics
        The intrinsics.
    scale
        Units of depth per metre.
    size
        Width and height of its images, pixels, None where the file does not say.
    distorted
        Whether the file has a distortion that is not zero, which is not used.
    """

    intrinsics: Intrinsics
    scale: float
    size: tuple[object, object]
    distorted: bool


def parse_depth(data: bytes, path: Path) -> Content:
    """Return the points of the depth image at `path`, one for each pixel.

    Raises
    ------
    UnreadableError
        If it is no 16-bit image, or no file beside it has the intrinsics.
    """
    depth = _pixels(data)
    found = camera_file(path)
    if found is None:
        raise UnreadableError("a depth image needs the camera's intrinsics", remedy=WHAT_TO_DO)
    camera = read_camera(found, path.stem)
    height, width = depth.shape
    for what, given, own in zip(("width", "height"), camera.size, (width, height), strict=True):
        if given is not None and given != own:
            raise UnreadableError(
                f"the image is {width} x {height} pixels, {what} in {found.name} is {given}",
                remedy="give the intrinsics of the depth camera at this resolution",
            )
    points = cloud_from_depth(depth, camera.intrinsics, camera.scale).reshape(-1, 3)
    notes = (f"the distortion in {found.name} is not used: rectify the image",) if camera.distorted else ()
    return Content(points, notes=notes)


def _pixels(data: bytes) -> NDArray[np.uint16]:
    """Return the values of a 16-bit PNG, shape (h, w)."""
    with extra("perception"):
        from PIL import Image

    try:
        with Image.open(BytesIO(data), formats=["PNG"]) as image:
            width, height = image.size
            mode = image.mode
            if mode.startswith("I") and 2 * width * height <= MOST_COMPRESSED * len(data):
                return np.asarray(image).astype(np.uint16)
    except Exception as reason:  # Pillow raises SyntaxError, OSError, ValueError and others on damaged files
        raise UnreadableError("the image is damaged or incomplete, expected a 16-bit PNG") from reason
    if mode.startswith("I"):
        raise UnreadableError(f"the header promises {width} x {height} pixels, more than the file can hold")
    raise UnreadableError(
        f"the image has mode {mode} (8 bits or colours), expected one 16-bit channel of depths",
        remedy="give the depth image, not the colour image",
    )


def camera_file(path: Path) -> Path | None:
    """Return the file with the intrinsics of the image at `path`, None if there is none.

    It is the JSON file with the image's name, one named in `NAMES` in the image's folder or that above it, or
    the only other file with intrinsics in the image's folder.
    """
    named = [
        path.with_suffix(".json"),
        *(folder / name for folder in (path.parent, path.parent.parent) for name in NAMES),
    ]
    found = next((file for file in named if file.is_file()), None)
    if found is not None:
        return found
    others = [file for file in sorted(path.parent.glob("*.json")) if _has_intrinsics(file, path.stem)]
    return others[0] if len(others) == 1 else None


def _has_intrinsics(file: Path, image: str) -> bool:
    try:
        read_camera(file, image)
    except UnreadableError:
        return False
    return True


def read_camera(file: Path, image: str) -> Camera:
    """Return the intrinsics in a JSON file.

    Known are fx, fy, cx, cy (or ppx, ppy), a matrix (cam_K, K, intrinsic_matrix, camera_matrix), and BOP's
    scene_camera.json, which has an entry for each image.

    Parameters
    ----------
    file
        The JSON file.
    image
        Name of the image without suffix, a number in BOP's data sets.

    Raises
    ------
    UnreadableError
        If it has no intrinsics.
    """
    try:
        content = json.loads(file.read_text("utf-8-sig"))
    except (OSError, ValueError, RecursionError) as reason:
        raise UnreadableError(f"{file.name} is no readable JSON file", remedy=WHAT_TO_DO) from reason
    for entry in _entries(content, image):
        four = _four(entry)
        if four is not None:
            try:
                intrinsics = Intrinsics(*four)
            except CloudError as reason:
                raise UnreadableError(f"{file.name}: {reason}", remedy=WHAT_TO_DO) from reason
            size = (entry.get("width"), entry.get("height"))
            return Camera(intrinsics, _scale(file, entry, content), size, _distorted(entry))
    raise UnreadableError(f"{file.name} has no intrinsics of image {image!r}", remedy=WHAT_TO_DO)


def _entries(content: object, image: str) -> Iterator[Json]:
    """Yield the objects that may have intrinsics: the image's, the file's own, those inside it."""
    if not isinstance(content, dict):
        return
    if image.isdecimal() and isinstance(content.get(str(int(image))), dict):
        yield content[str(int(image))]
    yield content
    inner = [
        (name, value) for name, value in content.items() if isinstance(value, dict) and not name.isdecimal()
    ]
    yield from (
        cast(Json, value) for _, value in sorted(inner, key=lambda pair: "depth" not in pair[0].lower())
    )


def _four(entry: Json) -> tuple[float, float, float, float] | None:
    """Return fx, fy, cx, cy, None if the object does not have them."""
    four = [
        entry.get("fx"),
        entry.get("fy"),
        entry.get("cx", entry.get("ppx")),
        entry.get("cy", entry.get("ppy")),
    ]
    if all(isinstance(value, int | float) for value in four):
        fx, fy, cx, cy = (float(cast(float, value)) for value in four)
        return fx, fy, cx, cy
    for name in ("cam_K", "K", "k", "intrinsic_matrix", "camera_matrix"):
        given = entry.get(name)
        given = given.get("data") if isinstance(given, dict) else given
        try:
            matrix = np.array(given, dtype=np.float64).reshape(3, 3)
        except (TypeError, ValueError):
            continue
        if matrix[2, :2].any():  # Open3D writes it by columns
            matrix = matrix.T
        return float(matrix[0, 0]), float(matrix[1, 1]), float(matrix[0, 2]), float(matrix[1, 2])
    return None


def _scale(file: Path, entry: Json, content: Json) -> float:
    """Return the units of depth per metre that `depth_scale` means.

    There are three conventions, whose values do not overlap: units per metre (TUM 5000, Open3D 1000),
    millimetres per unit (BOP, 1 or 0.1 for instance), and metres per unit (RealSense, 0.001 for instance).
    """
    given = entry.get("depth_scale", content.get("depth_scale"))
    if given is None:
        return MILLIMETRES
    if not isinstance(given, int | float) or not (isfinite(given) and given > 0.0):
        raise UnreadableError(
            f"depth_scale in {file.name} is {given!r}, expected a number above 0", remedy=WHAT_TO_DO
        )
    if given >= 100.0:
        return float(given)
    if given >= 0.015 or "cam_K" in entry:
        return MILLIMETRES / given
    return 1.0 / given


def _distorted(entry: Json) -> bool:
    for name in ("coeffs", "distortion", "distortion_coefficients", "D", "dist_coeffs"):
        given = entry.get(name)
        given = given.get("data") if isinstance(given, dict) and "data" in given else given
        values = [*given.values()] if isinstance(given, dict) else given
        if isinstance(values, list) and any(isinstance(value, int | float) and value for value in values):
            return True
    return False
