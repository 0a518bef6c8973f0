"""The markers of a run for RViz: belt, viewpoints, and the candidates of the last scan; in the belt frame."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from beltsort.cell.arrival import viewpoint_poses
from beltsort.cell.protocols import Cell, Scan
from beltsort.geometry import BeltLayout, Points, Pose
from beltsort.ros2.messages import Message, Published, Topic
from beltsort.sorting.entries import Scanned
from beltsort.sorting.kept_scans import TellsCandidate
from beltsort.sorting.perceived import PerceivedPosition
from beltsort.util.colours import COLOURS
from beltsort.util.text import position_number

MARKERS = Topic("~/markers", "visualization_msgs/MarkerArray")

ARROW, CUBE, CYLINDER, DOTS, TEXT = 0, 1, 3, 8, 9
"""Types of visualization_msgs/Marker."""
ADD, DELETE = 0, 2
"""Its actions."""

MOST_POINTS = 400
"""Number of points shown of each candidate."""
GREY, DARK, VIEWPOINT, CURRENT = "#999999", "#555555", COLOURS[0], COLOURS[1]
BELT_WIDTH, BELT_HEIGHT, RIM = 0.2, 0.01, 0.002
"""Size of the belt and height of a cup's rim as drawn, metres."""
ARROW_LENGTH, ARROW_SCALE = 0.06, (0.008, 0.02, 0.02)
"""Length of a viewpoint's arrow; diameters of shaft and head, and length of the head, metres."""
POINT, LETTER = 0.003, 0.03
"""Size of a point, and height of letters, metres."""


@dataclass(frozen=True, eq=False)
class Scene:
    """What does not change: the belt, names of the viewpoints, and the camera's pose at each if known."""

    layout: BeltLayout
    viewpoints: Sequence[str]
    poses: Sequence[Pose | None]

    @classmethod
    def of(cls, cell: Cell) -> "Scene":
        """Return that of a cell."""
        return cls(cell.layout, cell.viewpoints, viewpoint_poses(cell))


@dataclass(frozen=True, eq=False)
class SeenScan:
    """A scan that was used, and how far its objects have moved since.

    Attributes
    ----------
    content
        The content of its journal entry.
    candidates
        The candidate of each position, belt frame, metres; None where there is none.
    moved
        Number of positions by which the belt has moved since.
    """

    content: Scanned
    candidates: Sequence[Points | None]
    moved: int = 0

    @classmethod
    def of(cls, content: Scanned, _scan: Scan, perceived: Sequence[PerceivedPosition]) -> "SeenScan":
        """Return what is shown of a scan."""
        return cls(content, [seen.points if isinstance(seen, TellsCandidate) else None for seen in perceived])


def markers_of(scene: Scene, frame: str, labels: Sequence[str], seen: SeenScan | None) -> Published:
    """Return all markers.

    Parameters
    ----------
    scene
        Belt and viewpoints.
    frame
        The tf frame of the belt.
    labels
        Names of the model's labels.
    seen
        The last scan, whose candidates move with the belt and leave it at its end; None before the first.
    """
    drawing = _Drawing(frame)
    current = None if seen is None else seen.content.viewpoint
    return Published(
        MARKERS.name,
        {
            "markers": [
                *_belt(drawing, scene.layout),
                *_viewpoints(drawing, scene, current),
                *([] if seen is None else _candidates(drawing, scene.layout, labels, seen)),
            ]
        },
    )


@dataclass(frozen=True)
class _Drawing:
    """Makes markers in a frame."""

    frame: str

    def marker(self, ns: str, number: int, kind: int, colour: str, **fields: "Message | str") -> Message:
        """Return a marker."""
        red, green, blue = (int(colour[i : i + 2], 16) / 255.0 for i in (1, 3, 5))
        return {
            "header": {"frame_id": self.frame},  # stamp 0: at any time
            "ns": ns,
            "id": number,
            "type": kind,
            "action": ADD,
            "color": {"r": red, "g": green, "b": blue, "a": 1.0},
            **fields,
        }

    def text(self, ns: str, number: int, place: Points, text: str) -> Message:
        """Return text that faces the viewer."""
        size = {"z": LETTER}
        return self.marker(ns, number, TEXT, GREY, pose={"position": _point(place)}, scale=size, text=text)


def _belt(drawing: _Drawing, layout: BeltLayout) -> Iterator[Message]:
    """Yield the belt's surface, and the rim of the cup at each position."""
    length = layout.positions * layout.spacing
    middle = np.array([0.5 * (length - layout.spacing), 0.0, -0.5 * BELT_HEIGHT])
    size = {"x": length, "y": BELT_WIDTH, "z": BELT_HEIGHT}
    yield drawing.marker("belt", 0, CUBE, DARK, pose={"position": _point(middle)}, scale=size)
    for position in range(layout.positions):
        rim = layout.centre(position) + np.array([0.0, 0.0, layout.rim_height])
        size = {"x": 2.0 * layout.rim_radius, "y": 2.0 * layout.rim_radius, "z": RIM}
        yield drawing.marker(
            "positions", position, CYLINDER, GREY, pose={"position": _point(rim)}, scale=size
        )


def _viewpoints(drawing: _Drawing, scene: Scene, current: int | None) -> Iterator[Message]:
    """Yield an arrow from each viewpoint in its viewing direction, and its name."""
    width, head, length = ARROW_SCALE
    for number, (name, pose) in enumerate(zip(scene.viewpoints, scene.poses, strict=True)):
        if pose is None:
            continue
        eye, forward = pose[:3, 3], pose[:3, 2]
        ends = [_point(eye), _point(eye + ARROW_LENGTH * forward)]
        colour = CURRENT if number == current else VIEWPOINT
        arrow = drawing.marker(
            "viewpoints", number, ARROW, colour, scale={"x": width, "y": head, "z": length}
        )
        yield {**arrow, "points": ends}
        yield drawing.text("viewpoint names", number, eye + np.array([0.0, 0.0, LETTER]), name)


def _candidates(
    drawing: _Drawing, layout: BeltLayout, labels: Sequence[str], seen: SeenScan
) -> Iterator[Message]:
    """Yield the points of each candidate in the colour of its label, and the label above it."""
    content = seen.content
    for position in range(len(content.labels)):
        place = position + seen.moved  # that of the object when it was scanned
        if place >= len(content.labels):
            for ns, kind in (("candidates", DOTS), ("labels", TEXT)):
                yield {**drawing.marker(ns, position, kind, GREY), "action": DELETE}
            continue
        label, finding, points = content.labels[place], content.findings[place], seen.candidates[place]
        colour = GREY if label is None else COLOURS[label % len(COLOURS)]
        dots = drawing.marker("candidates", position, DOTS, colour, scale={"x": POINT, "y": POINT})
        if points is None or len(points) == 0:
            yield {**dots, "action": DELETE}
        else:
            shown = points[np.linspace(0, len(points) - 1, min(MOST_POINTS, len(points))).astype(np.intp)]
            way = layout.centre(position) - layout.centre(place)
            yield {**dots, "points": [_point(point + way) for point in shown]}
        above = layout.centre(position) + np.array([0.0, 0.0, layout.crop_height])
        name = finding if label is None else labels[label]
        yield drawing.text("labels", position, above, f"{position_number(position)}: {name}")


def _point(place: Points) -> Message:
    x, y, z = (float(value) for value in place)
    return {"x": x, "y": y, "z": z}
