"""Markers of a run, against the cell that they show."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from beltsort.geometry import BeltLayout, SphereViewpoint
from beltsort.ros2.markers import ADD, DELETE, MOST_POINTS, Scene, SeenScan, markers_of
from beltsort.sorting.entries import Scanned
from beltsort.util.colours import COLOURS

LAYOUT = BeltLayout(positions=2)
VIEWPOINT = SphereViewpoint("p1", azimuth=30.0, elevation=45.0)
SCENE = Scene(LAYOUT, ["p1", "p2"], [VIEWPOINT.pose(), None])
LABELS = ["round", "long"]
CLOUD = np.linspace([0.0, 0.0, 0.06], [0.05, 0.0, 0.1], 2 * MOST_POINTS)
SCAN = Scanned(
    viewpoint=0,
    labels=[1, None],
    empty=[False, True],
    findings=["object", "empty"],
    dropped=[],
    belief=[[0.5, 0.5]] * 2,
    last_labels=[[], []],
)


def drawn(seen: SeenScan | None) -> Mapping[tuple[str, int], Mapping[str, Any]]:
    message: Any = markers_of(SCENE, "belt", LABELS, seen).message
    return {(marker["ns"], marker["id"]): marker for marker in message["markers"]}


def test_belt_and_viewpoints_are_where_they_are() -> None:
    markers = drawn(None)
    assert {ns for ns, _ in markers} == {"belt", "positions", "viewpoints", "viewpoint names"}
    assert {marker["header"]["frame_id"] for marker in markers.values()} == {"belt"}
    rim = markers["positions", 1]["pose"]["position"]
    assert list(rim.values()) == [LAYOUT.spacing, 0.0, LAYOUT.rim_height]
    eye, ahead = (np.array(list(end.values())) for end in markers["viewpoints", 0]["points"])
    assert np.linalg.norm(eye) == pytest.approx(VIEWPOINT.radius)
    assert np.cross(eye, ahead) == pytest.approx(np.zeros(3), abs=1e-9)  # it looks at the belt end
    assert ("viewpoints", 1) not in markers  # its pose is not known
    belt = markers["belt", 0]
    first = belt["pose"]["position"]["x"] - 0.5 * belt["scale"]["x"]
    assert first == pytest.approx(-0.5 * LAYOUT.spacing)


def test_candidates_have_the_colours_of_their_labels() -> None:
    markers = drawn(SeenScan(SCAN, [CLOUD, None]))
    dots = markers["candidates", 0]
    assert dots["action"] == ADD
    assert len(dots["points"]) == MOST_POINTS
    assert list(dots["points"][-1].values()) == pytest.approx(CLOUD[-1])
    assert round(255 * dots["color"]["r"]) == int(COLOURS[1][1:3], 16)
    assert markers["labels", 0]["text"] == "1: long"
    assert markers["candidates", 1]["action"] == DELETE  # that of the scan before
    assert markers["labels", 1]["text"] == "2: empty"
    assert markers["viewpoints", 0]["color"] != drawn(None)["viewpoints", 0]["color"]


def test_candidates_move_with_the_belt_and_leave_it() -> None:
    behind = CLOUD + LAYOUT.centre(1)
    seen = SeenScan(replace(SCAN, labels=[1, 0], findings=["object", "object"]), [CLOUD, behind])
    moved = drawn(replace(seen, moved=1))
    dots = moved["candidates", 0]
    assert list(dots["points"][-1].values()) == pytest.approx(CLOUD[-1])
    assert moved["labels", 0]["text"] == "1: round"
    assert [moved[ns, 1]["action"] for ns in ("candidates", "labels")] == [DELETE, DELETE]
    gone = drawn(replace(seen, moved=3))
    assert {gone[ns, n]["action"] for ns in ("candidates", "labels") for n in (0, 1)} == {DELETE}
