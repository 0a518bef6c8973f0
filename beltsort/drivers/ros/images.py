"""Points of depth images, `sensor_msgs/Image` with its `sensor_msgs/CameraInfo`."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from beltsort.errors import CellError
from beltsort.geometry import Points

ENCODINGS = {"16UC1": ("u2", 1e-3), "mono16": ("u2", 1e-3), "32FC1": ("f4", 1.0)}
"""NumPy type and unit (metres) of the depths, by the image's encoding."""


def points_of_image(image: Mapping[str, Any], info: Mapping[str, Any], data: bytes) -> Points:
    """Return the points of a rectified depth image in the optical frame.

    Parameters
    ----------
    image
        Fields of a sensor_msgs/Image.
    info
        Fields of the sensor_msgs/CameraInfo of the same camera, names of matrices in lower case.
    data
        The image's rows; 16UC1 in millimetres, 32FC1 in metres.

    Returns
    -------
    Points
        Shape (height, width, 3), metres; NaN where there is no return.

    Raises
    ------
    CellError
        If the image is not a depth image, is truncated or shows nothing, or the camera info is not its own.

    Examples
    --------
    >>> image = {"height": 1, "width": 2, "encoding": "16UC1", "step": 4, "is_bigendian": 0}
    >>> info = {"height": 1, "width": 2, "k": [500, 0, 1, 0, 500, 0, 0, 0, 1], "p": [0.0] * 12}
    >>> points_of_image(image, info, bytes([0xF4, 0x01, 0, 0]))
    array([[[-0.001,  0.   ,  0.5  ],
            [   nan,    nan,    nan]]])
    """
    depths = _depths(image, data)
    fx, fy, cx, cy = _intrinsics(image, info)
    rows, columns = np.indices(depths.shape)
    points: Points = np.stack([(columns - cx) / fx * depths, (rows - cy) / fy * depths, depths], axis=-1)
    return points


def _depths(image: Mapping[str, Any], data: bytes) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Return depths, shape (height, width), metres, NaN where there is none."""
    height, width, step, encoding = image["height"], image["width"], image["step"], image["encoding"]
    if height < 1 or width < 1:
        raise CellError(f"the image is empty ({height} x {width} pixels), expected pixels; check the camera")
    if encoding not in ENCODINGS:
        raise CellError(
            f"the image's encoding is {encoding!r}, expected a depth image, {' or '.join(ENCODINGS)}; take "
            "the camera's depth topic"
        )
    kind, unit = ENCODINGS[encoding]
    row = width * np.dtype(kind).itemsize
    if step < row:
        raise CellError(
            f"the image's step is {step}, expected at least {row} ({width} pixels of {encoding}); correct "
            "its publisher"
        )
    if len(data) < (needed := (height - 1) * step + row):
        raise CellError(
            f"the image is truncated: {len(data)} bytes in rows of {step}, expected {needed} for {height} x "
            f"{width} pixels of {encoding}; look at its publisher"
        )
    order = ">" if image["is_bigendian"] else "<"
    pixels: np.ndarray[tuple[int, ...], np.dtype[Any]] = np.ndarray(
        (height, width), order + kind, data, strides=(step, np.dtype(kind).itemsize)
    )
    depths = pixels.astype(np.float64) * unit
    depths[~np.isfinite(depths) | (depths <= 0.0)] = np.nan
    if np.isnan(depths).all():
        raise CellError(
            f"none of the {height * width} pixels has a finite depth above 0, expected some returns; check "
            "what is in front of the camera, and its distance"
        )
    return depths


def _intrinsics(image: Mapping[str, Any], info: Mapping[str, Any]) -> tuple[float, float, float, float]:
    """Return focal lengths and principal point, pixels, of the rectified image: those of P, else of K."""
    size, expected = (info["height"], info["width"]), (image["height"], image["width"])
    if size != expected:
        raise CellError(
            f"the camera info is of {size[0]} x {size[1]} pixels, expected {expected[0]} x {expected[1]}, "
            "those of the image; take the camera info of the depth image, not of the colour image"
        )
    matrix, columns = (info["p"], 4) if info["p"][0] > 0.0 else (info["k"], 3)
    fx, fy, cx, cy = matrix[0], matrix[columns + 1], matrix[2], matrix[columns + 2]
    if not (np.isfinite([fx, fy, cx, cy]).all() and fx > 0.0 and fy > 0.0):
        raise CellError(
            f"the camera info has focal lengths {fx:g} and {fy:g} and the principal point ({cx:g}, {cy:g}), "
            "expected finite numbers and focal lengths above 0; calibrate the camera"
        )
    return fx, fy, cx, cy
