"""What a recording shows of a cell in space: belt, cups and viewpoints, the camera, clouds and candidates."""

from collections.abc import Iterator, Sequence
from types import ModuleType
from typing import Any

import numpy as np

from beltsort.cell.protocols import Cell, KnowsPoses, Scan
from beltsort.geometry import BeltLayout, Points, Pose, transform
from beltsort.util.colours import COLOURS
from beltsort.util.text import position_number

Logged = tuple[str, list[Any]]
"""Path of an entity, and its archetypes."""

GREY, DARK = "#999999", "#555555"
MOST_POINTS = 20_000  # of the pixels of a scan
PIXELS = 8  # from each pixel to the next of those that tell the field of view
ELEVATIONS = (0.0, 30.0, 60.0)  # degrees; circles of the half-sphere
FRUSTUM = 0.08  # metres; length of the camera's symbol
LINE = 0.001  # metres; radius of a line
POINT = 0.0015  # metres; radius of a point of a candidate
BELT_WIDTH = 0.2  # metres; drawn only


def rgb(colour: str) -> list[int]:
    """Return red, green and blue, 0 to 255, of a colour such as `#0072B2`."""
    return [int(colour[i : i + 2], 16) for i in (1, 3, 5)]


def class_colour(index: int) -> list[int]:
    """Return the colour of a class, label or bin."""
    return rgb(COLOURS[index % len(COLOURS)])


def fixed(rerun: ModuleType, cell: Cell) -> Iterator[Logged]:
    """Yield what does not change: the belt with its cups, and the half-sphere with the viewpoints."""
    yield "world", [rerun.ViewCoordinates.RIGHT_HAND_Z_UP, rerun.TransformAxes3D(0.1)]
    yield from _belt(rerun, cell.layout)
    poses = cell.poses if isinstance(cell, KnowsPoses) else ()
    known = [(name, pose) for name, pose in zip(cell.viewpoints, poses, strict=False) if pose is not None]
    if known:
        places = np.array([pose[:3, 3] for _, pose in known])
        names = [name for name, _ in known]
        dots = rerun.Points3D(places, radii=0.012, colors=rgb(COLOURS[1]), labels=names, show_labels=True)
        yield "world/viewpoints", [dots]
        radius = float(np.linalg.norm(places, axis=1).mean())
        circles = [_circle(radius, elevation) for elevation in ELEVATIONS]
        yield "world/viewpoints/half_sphere", [rerun.LineStrips3D(circles, radii=LINE, colors=rgb(GREY))]


def _belt(rerun: ModuleType, layout: BeltLayout) -> Iterator[Logged]:
    length = layout.positions * layout.spacing
    surface = rerun.Boxes3D(
        centers=[0.5 * length - 0.5 * layout.spacing, 0.0, -0.005],
        sizes=[length, BELT_WIDTH, 0.01],
        colors=rgb(DARK),
    )
    yield "world/belt", [surface]
    turn = np.linspace(0.0, 2.0 * np.pi, 49)
    ring = np.column_stack([np.cos(turn), np.sin(turn), np.zeros_like(turn)]) * layout.rim_radius
    for j in range(layout.positions):
        rim = layout.centre(j) + ring + np.array([0.0, 0.0, layout.rim_height])
        yield (
            f"world/belt/rim_{position_number(j)}",
            [rerun.LineStrips3D([rim], radii=LINE, colors=rgb(GREY))],
        )


def _circle(radius: float, elevation: float) -> Points:
    """Return a circle of equal elevation (degrees) around the belt end, shape (n, 3)."""
    turn, up = np.linspace(0.0, 2.0 * np.pi, 97), np.radians(elevation)
    flat = radius * np.cos(up)
    height = np.full_like(turn, radius * np.sin(up))
    return np.column_stack([flat * np.cos(turn), flat * np.sin(turn), height])


def camera(rerun: ModuleType, scan: Scan) -> Iterator[Logged]:
    """Yield the camera's frame, with its field of view, and the cloud of a scan in the belt frame."""
    pose: Pose = scan.world_from_camera
    frame = rerun.Transform3D(translation=pose[:3, 3], mat3x3=pose[:3, :3])
    yield "world/camera", [frame, rerun.TransformAxes3D(FRUSTUM), *_field_of_view(rerun, scan.points)]
    points = scan.points.reshape(-1, 3)
    points = points[:: len(points) // MOST_POINTS + 1]
    shown = transform(pose, points[np.isfinite(points).all(axis=1)])
    yield "world/scan", [rerun.Points3D(shown, radii=0.5 * POINT, colors=rgb(GREY))]


def _field_of_view(rerun: ModuleType, points: Points) -> list[Any]:
    """Return the camera's pinhole if the scan is a depth image with returns, else nothing."""
    if points.ndim != 3:
        return []
    height, width, _ = points.shape
    points = points[::PIXELS, ::PIXELS]
    if not np.isfinite(points).any():
        return []
    with np.errstate(invalid="ignore", divide="ignore"):
        across, down = (np.nanmax(np.abs(points[..., i] / points[..., 2])) for i in (0, 1))
    focal = (0.5 * width / across, 0.5 * height / down)
    view = rerun.Pinhole(
        focal_length=focal,
        width=width,
        height=height,
        camera_xyz=rerun.ViewCoordinates.RDF,
        image_plane_distance=FRUSTUM,
    )
    return [view]


def candidate(rerun: ModuleType, points: Points | None, colour: list[int]) -> Any:
    """Return the candidate of a position, in the belt frame; if there is none, what clears an earlier one."""
    if points is None or len(points) == 0:
        return rerun.Points3D(np.zeros((0, 3)))
    return rerun.Points3D(points, radii=POINT, colors=colour)


def names_above(rerun: ModuleType, layout: BeltLayout, names: Sequence[str]) -> Any:
    """Return a name above each position."""
    places = [layout.centre(j) + np.array([0.0, 0.0, layout.crop_height]) for j in range(layout.positions)]
    return rerun.Points3D(places, radii=0.002, colors=rgb(GREY), labels=list(names), show_labels=True)
