"""Depth images become points, and those that cannot be are refused."""

from typing import Any

import numpy as np
import pytest

from beltsort.drivers.ros.images import points_of_image
from beltsort.errors import CellError

DEPTHS = np.array([[0.5, 0.0, 0.6], [0.7, 0.8, 0.9]])
INFO = {"height": 2, "width": 3, "k": [500.0, 0, 1.0, 0, 400.0, 0.5, 0, 0, 1], "p": [0.0] * 12}


def image(kind: str = "<f4", step: int = 0, **changes: Any) -> tuple[dict[str, Any], bytes]:
    """Return the fields of an image and its rows, each filled up to `step` bytes."""
    pixels = (DEPTHS if kind.endswith("f4") else np.round(1e3 * DEPTHS)).astype(kind)
    rows = [row.tobytes() for row in pixels]
    step = step or len(rows[0])
    fields = {
        "height": 2,
        "width": 3,
        "encoding": "32FC1" if kind.endswith("f4") else "16UC1",
        "step": step,
        "is_bigendian": int(kind.startswith(">")),
    }
    return {**fields, **changes}, b"".join(row.ljust(step, b"x") for row in rows)


@pytest.mark.parametrize("kind", ["<f4", ">f4", "<u2", ">u2"])
@pytest.mark.parametrize("step", [0, 16])
def test_points_are_in_metres_whatever_the_encoding(kind: str, step: int) -> None:
    fields, data = image(kind, step)
    points = points_of_image(fields, INFO, data)
    np.testing.assert_allclose(points[..., 2], np.where(DEPTHS > 0.0, DEPTHS, np.nan), rtol=1e-6)
    np.testing.assert_allclose(points[1, 0], [-0.7 / 500, 0.5 * 0.7 / 400, 0.7], rtol=1e-6)


def test_the_projection_of_the_rectified_image_comes_first() -> None:
    projection = [250.0, 0, 1.0, 0, 0, 250.0, 0.5, 0, 0, 0, 1, 0]
    points = points_of_image(image()[0], {**INFO, "p": projection}, image()[1])
    np.testing.assert_allclose(points[1, 0], [-0.7 / 250, 0.5 * 0.7 / 250, 0.7], rtol=1e-6)


def test_infinity_is_no_return() -> None:
    fields, _ = image()
    pixels = np.array([[np.inf, np.nan, -1.0], [0.0, 0.5, np.inf]], "<f4")
    depths = points_of_image(fields, INFO, pixels.tobytes())[..., 2]
    assert np.isfinite(depths).tolist() == [[False] * 3, [False, True, False]]


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"encoding": "rgb8"}, r"'rgb8'.*\b16UC1\b.*\b32FC1\b.*\bdepth topic\b"),
        ({"height": 0}, r"\bempty \(0 x 3 pixels\)"),
        ({"step": 8}, r"\bstep is 8\b.*\bat least 12\b"),
        ({"step": 24}, r"\btruncated: 24 bytes\b.*\b36\b"),
        ({"width": 2}, r"\bcamera info is of 2 x 3\b.*\b2 x 2\b"),
    ],
)
def test_an_image_that_is_none(changes: dict[str, Any], said: str) -> None:
    fields, data = image()
    with pytest.raises(CellError, match=said):
        points_of_image({**fields, **changes}, INFO, data)


def test_an_image_of_nothing() -> None:
    with pytest.raises(CellError, match=r"\bnone of the 6 pixels\b"):
        points_of_image(image()[0], INFO, bytes(24))


@pytest.mark.parametrize("matrix", [[0.0] * 9, [500.0, 0, 1, 0, float("nan"), 1, 0, 0, 1]])
def test_a_camera_that_is_not_calibrated(matrix: list[float]) -> None:
    with pytest.raises(CellError, match=r"\bfocal lengths\b.*\bcalibrate\b"):
        points_of_image(image()[0], {**INFO, "k": matrix}, image()[1])
