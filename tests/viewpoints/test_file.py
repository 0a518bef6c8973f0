"""The file: what is written is read, what is not understood or contradicts itself is refused."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from beltsort.errors import ViewpointError
from beltsort.viewpoints import Sampling, ViewpointMap, map_viewpoints

Data = dict[str, Any]


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "viewpoints.json"


def views() -> ViewpointMap:
    return map_viewpoints(Sampling("uniform", 30, 0.5, seed=7), 3, lowest=10.0, note="a test")


def test_what_is_written_is_read(path: Path) -> None:
    written = views()
    written.save(path)
    read = ViewpointMap.load(path)
    for name in ("points", "reachable", "edges", "motion_cost"):
        np.testing.assert_array_equal(getattr(read, name), getattr(written, name))
    for name in ("chosen", "names", "sampling", "lowest", "note", "neighbours_only", "viewpoints", "travel"):
        assert getattr(read, name) == getattr(written, name)
    read.save(again := path.with_suffix(".again"))
    assert again.read_bytes() == path.read_bytes()


def test_the_file_says_all_that_a_cell_needs(path: Path) -> None:
    written = views()
    written.save(path)
    data = json.loads(path.read_text())
    assert data["sampling"] == {"method": "uniform", "count": 30, "radius": 0.5, "seed": 7}
    for k, viewpoint in enumerate(data["viewpoints"]):
        assert viewpoint["name"] == f"p{k + 1}"
        assert viewpoint["position"] == data["graph"]["points"][viewpoint["point"]]
        pose = np.array(viewpoint["world_from_camera"])
        np.testing.assert_allclose(pose[:3, 3], viewpoint["position"], atol=1e-12)
        np.testing.assert_allclose(pose[:3, 3] + 0.5 * pose[:3, 2], 0.0, atol=1e-12)


def test_viewpoints_may_be_renamed_by_hand(path: Path) -> None:
    views().save(path)
    path.write_text(path.read_text().replace('"p2"', '"beside"'))
    assert ViewpointMap.load(path).names == ("p1", "beside", "p3")


def put(*keys: str | int, value: Any) -> Callable[[Data], object]:
    def change(data: Any) -> None:
        for key in keys[:-1]:
            data = data[key]
        data[keys[-1]] = value

    return change


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (put("motion_costs", value=[]), r"motion_costs: .*\bunknown\b.*'motion_cost'"),
        (put("graph", "edge", value=[]), r"graph\.edge: .*\bunknown\b.*'edges'"),
        (put("sampling", "sead", value=1), r"sampling\.sead: .*\bunknown\b.*'seed'"),
        (
            put("viewpoints", 1, "pose", value=1),
            r"viewpoints\[1\]\.pose: .*\bunknown\b.*name, point, position, world_from_camera",
        ),
        (lambda data: data.pop("travel"), r"travel: is missing; add it: .*\bone move reaches"),
        (lambda data: data["graph"].pop("edges"), r"graph\.edges: is missing; add it: Pairs of neighbours"),
        (put("graph", value=3), r"\bgraph\b.*\b3\b.*points, reachable, edges"),
        (put("viewpoints", value="p1"), r"viewpoints: .*'p1'.*\barray\b"),
        (put("viewpoints", 0, "name", value=1), r"viewpoints\[0\]\.name: .*\b1\b.*\bstring\b"),
        (put("viewpoints", 0, "point", value=1.5), r"viewpoints\[0\]\.point: .*\b1\.5\b.*\binteger\b"),
        (put("viewpoints", 0, "point", value=True), r"viewpoints\[0\]\.point: .*\bTrue\b.*\binteger\b"),
        (put("viewpoints", 0, "point", value=900), r"point 900\b.*\b0, 1, 2, "),
        (put("lowest", value="low"), r"lowest: .*'low'.*\bnumber\b"),
        (put("neighbours_only", value=1), r"neighbours_only: .*\b1\b.*\bboolean\b"),
        (put("sampling", "method", value="spiral"), r"method 'spiral'.*fibonacci, uniform"),
        (put("sampling", "radius", value=0.7), r"points\[0\] .*\b0\.7 m"),
        (put("graph", "points", 4, value=[0.0, 1.0]), r"graph\.points\[4\]: .*\[0\.0, 1\.0\].*\b3 entries"),
        (
            put("graph", "reachable", value=[1.0] * 30),
            r"graph\.reachable\[0\]: .*\b1\.0\b.*\bboolean\b[^$]*\n.*\b22 more problems",
        ),
        (
            put("graph", "edges", 0, value=[0.0, 1.0]),
            r"graph\.edges\[0\]\[1\]: .*\b1\.0\b.*\binteger\b",
        ),
        (put("graph", "edges", 0, value=[0, 2**64]), r"graph\.edges\[0\]\[1\]: .*\b18446744073709551616\b"),
        (put("note", value="\ud800"), r"cannot be read: Invalid JSON"),
        (put("graph", "edges", value=[]), r"graph .*\b26 parts"),
        (put("motion_cost", 0, 1, value=2.5), r"motion_cost\b.*2\.5.*`beltsort viewpoints`.*SortingModel"),
        (put("motion_cost", value=[[1.0]]), r"motion_cost\b.*\[\[1\.0\]\].*`beltsort viewpoints`"),
        (put("travel", 0, value=[0]), r"travel\b.*\[\[0\], .*`beltsort viewpoints`"),
        (put("viewpoints", 2, "position", 1, value=0.4), r"viewpoints\b.*'p1', .*`beltsort viewpoints`"),
        (
            put("viewpoints", 0, "world_from_camera", 0, value=None),
            r"viewpoints\[0\]\.world_from_camera\[0\]: .*\bNone\b.*\barray\b",
        ),
    ],
)
def test_what_is_refused(path: Path, change: Callable[[Data], object], message: str) -> None:
    views().save(path)
    data = json.loads(path.read_text())
    change(data)
    path.write_text(json.dumps(data))
    with pytest.raises(ViewpointError, match=message) as caught:
        ViewpointMap.load(path)
    assert str(caught.value).startswith(f"{path}: ")


@pytest.mark.parametrize("content", ["", "[", "[]", "\x00"])
def test_no_json_object(path: Path, content: str) -> None:
    path.write_text(content)
    with pytest.raises(ViewpointError, match=r"Expecting value|\[\].*\bviewpoints, motion_cost, "):
        ViewpointMap.load(path)


def test_no_text_and_no_file(path: Path) -> None:
    with pytest.raises(ViewpointError, match=r"No such file.*`beltsort viewpoints`"):
        ViewpointMap.load(path)
    path.write_bytes(b"\xff\xfe\xff")
    with pytest.raises(ViewpointError, match=r"decode.*`beltsort viewpoints`"):
        ViewpointMap.load(path)
