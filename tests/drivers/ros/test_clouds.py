"""PointCloud2 as cameras write it, and as they should not."""

import dataclasses
from typing import Any

import numpy as np
import pytest

from beltsort.drivers.ros.clouds import Cloud, packed, points_of
from beltsort.errors import CellError

POINTS = np.random.default_rng(3).normal(size=(4, 5, 3)).astype(np.float32).astype(np.float64)


def laid_out(kind: str, order: str, *, gap: int, margin: int) -> Cloud:
    """Return the points in another layout: z, colour, x, y, padded behind each point and each row."""
    fields = [
        ("z", order + kind),
        ("rgb", "<u4"),
        ("x", order + kind),
        ("y", order + kind),
        ("pad", f"V{gap}"),
    ]
    rows = np.zeros((4, 5), np.dtype(fields))
    for i, name in enumerate("xyz"):
        rows[name] = POINTS[..., i]
    lines = [row.tobytes() + bytes(margin) for row in rows]
    number = {"f4": 7, "f8": 8}[kind]
    size = np.dtype(kind).itemsize
    places = {"z": (0, number), "rgb": (size, 6), "x": (size + 4, number), "y": (2 * size + 4, number)}
    step = rows.dtype.itemsize
    return Cloud(4, 5, places, order == ">", step, 5 * step + margin, b"".join(lines))


@pytest.mark.parametrize("kind", ["f4", "f8"])
@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize(("gap", "margin"), [(1, 0), (16, 0), (4, 10)])
def test_any_layout_gives_the_same_points(kind: str, order: str, gap: int, margin: int) -> None:
    np.testing.assert_array_equal(points_of(laid_out(kind, order, gap=gap, margin=margin)), POINTS)


def test_one_row_is_not_organised() -> None:
    assert points_of(packed(POINTS[0])).shape == (5, 3)
    assert points_of(packed(POINTS[:1])).shape == (5, 3)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"data": packed(POINTS).data[:-1]}, r"truncated\b.*\b239 bytes\b.*\b60\b.*\b240\b"),
        ({"height": 5}, "truncated"),
        ({"row_step": 59}, r"\brow_step\b.*\b59\b.*\b60\b"),
        ({"row_step": 0}, r"\brow_step\b.*\b0\b.*\b60\b"),
        ({"width": 0}, r"empty\b.*\b4 x 0 points\b"),
        ({"height": 0}, r"empty\b.*\b0 x 5 points\b"),
        ({"fields": {}}, r"field 'x'.*\bfloat32 \(7\) or float64 \(8\)"),
        (
            {"fields": {"x": (0, 7), "y": (4, 7), "z": (10, 7)}},
            r"field 'z'.*\bfloat32 \(7\) or float64 \(8\)",
        ),
        ({"fields": {"x": (0, 7), "y": (4, 5), "z": (8, 7)}}, r"field 'y'.*\bfloat32 \(7\) or float64 \(8\)"),
        ({"point_step": 0}, r"field 'x'.*\b0 bytes\b"),
    ],
)
def test_broken_clouds_are_refused(changes: dict[str, Any], said: str) -> None:
    with pytest.raises(CellError, match=said):
        points_of(dataclasses.replace(packed(POINTS), **changes))


def test_a_single_row_needs_no_row_step() -> None:
    row = packed(POINTS[0])
    np.testing.assert_array_equal(points_of(dataclasses.replace(row, row_step=0)), points_of(row))


def test_a_point_at_the_camera_is_no_return() -> None:
    points = POINTS.copy()
    points[1, 2] = 0.0
    seen = points_of(packed(points))
    assert np.isnan(seen[1, 2]).all()
    assert np.isfinite(seen).sum() == np.isfinite(POINTS).sum() - 3
    with pytest.raises(CellError, match=r"\b20 points\b.*\breturns\b"):
        points_of(packed(np.zeros_like(POINTS)))


def test_infinite_coordinates_are_not_returns() -> None:
    points = POINTS.copy()
    points[..., 2] = np.inf
    with pytest.raises(CellError, match=r"\b20 points\b.*\bfinite\b"):
        points_of(packed(points))
