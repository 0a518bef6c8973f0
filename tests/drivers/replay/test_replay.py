"""Recorded cells, played back from bags of every format."""

import dataclasses
import tracemalloc
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from beltsort.cell import CommandError, Outcome
from beltsort.drivers.replay import Replay, ReplayOptions
from beltsort.drivers.ros.clouds import Cloud, packed
from beltsort.errors import CellError
from beltsort.geometry import Points
from tests.drivers.replay import bags

P1, P2 = {"elbow": 0.1, "wrist": 0.2}, {"elbow": 0.5, "wrist": -0.2}


def depth_image(n: int) -> Points:
    """Return a small organised cloud that names its number and has a hole, shape (2, 3, 3)."""
    points = np.full((2, 3, 3), float(n))
    points[..., 2] = 0.75  # exact in float32
    points[1, 2] = np.nan
    return points


def options(path: Path, **changes: Any) -> ReplayOptions:
    foreign = ReplayOptions(
        str(path),
        ("p1", "p2"),
        scan_topic="/camera/points",
        joint_topic="/joint_states",
        taught={"p1": P1, "p2": P2},
    )
    return dataclasses.replace(foreign, **changes)


def foreign_record() -> Iterator[bags.Message]:
    """Two visits to p1 and one to p2, with what is published on the way."""
    yield bags.transform(0.0, "world", "base", (1.0, 0.0, 0.0), topic="/tf_static")
    for n, (viewpoint, begin) in enumerate([(P1, 1.0), (P2, 3.0), (P1, 5.0)]):
        halfway = {name: position + 0.1 for name, position in viewpoint.items()}
        yield bags.joints(begin - 0.5, halfway)
        yield bags.cloud(begin - 0.4, depth_image(100))
        yield bags.joints(begin, viewpoint)
        for k in range(2):
            time = begin + 0.25 * (k + 1)
            yield bags.joints(time - 0.05, {**viewpoint, "gripper": 0.0})
            yield bags.transform(time, "base", "camera", (0.0, 0.0, 0.5 + n))
            yield bags.cloud(time + 0.01, depth_image(10 * n + k))


@pytest.fixture(params=bags.FORMATS)
def record(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    return bags.write(tmp_path, request.param, foreign_record())


def first(points: Points) -> float:
    return float(points[0, 0, 0])


def test_scans_come_by_viewpoint_in_the_order_of_the_record(record: Path) -> None:
    with Replay(options(record)) as cell:
        stop = cell.move_to(0, "one")
        scan = cell.scan(not_before=stop)
        assert (scan.stamp, scan.frame) == (1.26, "camera")
        np.testing.assert_array_equal(scan.points, depth_image(0))
        expected = np.eye(4)  # turned over twice
        expected[:3, 3] = (1.0, 0.0, -0.5)
        np.testing.assert_allclose(scan.world_from_camera, expected, atol=1e-15)
        stop = cell.move_to(1, "two")
        assert first(cell.scan(not_before=stop).points) == 10.0
        assert first(cell.scan(not_before=stop).points) == 11.0
        stop = cell.move_to(0, "three")
        assert first(cell.scan(not_before=stop).points) == 20.0
        assert first(cell.scan(not_before=5.4).points) == 21.0


def test_a_record_at_its_end_says_so(record: Path) -> None:
    with Replay(options(record)) as cell:
        cell.move_to(1, "one")
        cell.scan(not_before=3.4)
        with pytest.raises(CommandError, match=r"viewpoint 'p2' .*\b3\.510\b.*\b2 of 9\b") as error:
            cell.scan(not_before=0.0)
        assert error.value.outcome is Outcome.NOT_DONE
        assert first(cell.scan(not_before=cell.move_to(0, "two")).points) == 20.0


def test_stale_scan(record: Path) -> None:
    with Replay(options(record)) as cell:
        cell.move_to(0, "one")
        assert cell.scan(not_before=1.3).stamp == 1.51


def test_restarted(record: Path) -> None:
    with Replay(options(record)) as cell:
        boot = cell.health()
        assert first(cell.scan(not_before=cell.move_to(0, "one")).points) == 0.0
        cell.close()
        assert cell.health() == boot
        assert first(cell.scan(not_before=0.0).points) == 1.0


@pytest.mark.parametrize("form", bags.FORMATS)
def test_a_pose_topic_and_announced_stops_and_objects(form: str, tmp_path: Path) -> None:
    def record() -> Iterator[bags.Message]:
        for n in range(3):
            yield bags.stop(float(n), "/object", str(n))
            yield bags.stop(n + 0.1, "/viewpoint", "p2")
            yield bags.pose(n + 0.2, (0.0, float(n), 0.7))
            yield bags.cloud(n + 0.2, depth_image(n)[0])
            yield bags.cloud(n + 0.2, depth_image(n + 50)[0])

    told = {"pose_topic": "/camera/pose", "viewpoint_topic": "/viewpoint", "object_topic": "/object"}
    path = bags.write(tmp_path, form, record())
    with Replay(options(path, joint_topic="", taught={}, **told)) as cell:
        cell.move_to(1, "one")
        scan = cell.scan(not_before=0.0)
        np.testing.assert_array_equal(scan.points, depth_image(0)[0])
        np.testing.assert_array_equal(cell.scan(not_before=0.0).points, depth_image(50)[0])
        with pytest.raises(CommandError, match=r"viewpoint 'p2' of object 0\b"):
            cell.scan(not_before=0.0)
        assert cell.advance_to(2, "two") == 2.0
        assert cell.scan(not_before=2.0).world_from_camera[1, 3] == 2.0
        with pytest.raises(CommandError, match=r"\bobject 1\b.*\bobject 2\b") as error:
            cell.advance_to(1, "three")
        assert error.value.outcome is Outcome.NOT_DONE


def test_without_a_pose_near_the_scan_it_is_refused_and_the_next_one_served(tmp_path: Path) -> None:
    record = [
        bags.stop(0.0, "/viewpoint", "p1"),
        bags.transform(0.0, "world", "camera", (0.0, 0.0, 1.0)),
        bags.cloud(0.5, depth_image(0)),
        bags.transform(1.0, "world", "camera", (0.0, 0.0, 1.0)),
        bags.cloud(1.0, depth_image(1)),
    ]
    path = bags.write(tmp_path, "mcap", record)
    with Replay(options(path, joint_topic="", taught={}, viewpoint_topic="/viewpoint")) as cell:
        cell.move_to(0, "one")
        with pytest.raises(CommandError, match=r"'camera'.*'world'.*\b0\.500\b.*\b0\.500 s\b"):
            cell.scan(not_before=0.0)
        assert cell.scan(not_before=0.0).stamp == 1.0


def truncated_cloud() -> Cloud:
    whole = packed(depth_image(0))
    return dataclasses.replace(whole, data=whole.data[:-1])


@pytest.mark.parametrize(
    ("broken", "said"),
    [
        (np.empty((0, 3)), r"cloud\b.*\bempty\b"),
        (np.full((2, 2, 3), np.nan), r"\b4 points\b.*\bfinite\b"),
        (truncated_cloud(), r"cloud\b.*\btruncated\b.*\b71 bytes\b.*\b72\b"),
        (
            dataclasses.replace(packed(depth_image(0)), fields={"x": (0, 7), "y": (4, 7)}),
            r"field 'z'.*\bfloat32 \(7\) or float64 \(8\)",
        ),
    ],
    ids=["empty cloud", "NaN-only cloud", "truncated cloud", "cloud without z"],
)
def test_unusable_clouds_are_refused(broken: Points | Cloud, said: str, tmp_path: Path) -> None:
    path = bags.write(
        tmp_path,
        "mcap",
        [
            bags.stop(0.0, "/viewpoint", "p1"),
            bags.transform(0.0, "world", "camera", (0.0, 0.0, 1.0)),
            bags.cloud(0.0, broken),
            bags.cloud(0.1, depth_image(1)),
        ],
    )
    with Replay(options(path, joint_topic="", taught={}, viewpoint_topic="/viewpoint")) as cell:
        cell.move_to(0, "one")
        with pytest.raises(CommandError, match=said) as error:
            cell.scan(not_before=0.0)
        assert error.value.outcome is Outcome.NOT_DONE
        assert first(cell.scan(not_before=0.0).points) == 1.0


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        (
            {"scan_topic": "/other"},
            r"'/other' .*\bNone\b.* /camera/points \(sensor_msgs/msg/PointCloud2\)",
        ),
        (
            {"scan_topic": "/joint_states"},
            "'/joint_states' .*sensor_msgs/msg/JointState.*sensor_msgs/msg/PointCloud2",
        ),
        ({"joint_topic": "", "taught": {}}, r"'/beltsort/viewpoint' .*\bNone\b.* /camera/points "),
        ({"pose_topic": "/pose"}, r"'/pose' .*\bNone\b.* /camera/points "),
    ],
)
def test_a_bag_without_what_the_options_name(changes: dict[str, Any], said: str, tmp_path: Path) -> None:
    path = bags.write(tmp_path, "mcap", foreign_record())
    with pytest.raises(CellError, match=said):
        Replay(options(path, **changes)).connect()


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"taught": {}}, r"joint_topic\b.*taught\b.*\[\]"),
        ({"taught": {"p1": P1}}, r"taught\b.*\['p1'\].*\['p1', 'p2'\]"),
    ],
)
def test_options_that_do_not_fit(changes: dict[str, Any], said: str) -> None:
    with pytest.raises(CellError, match=said):
        options(Path("unused"), **changes)


@pytest.mark.parametrize("form", bags.FORMATS)
def test_memory_does_not_grow_with_the_record(form: str, tmp_path: Path) -> None:
    scans, image = 40, np.full((100, 200, 3), 0.5)  # 240 kB each

    def record() -> Iterator[bags.Message]:
        yield bags.stop(0.0, "/viewpoint", "p1")
        for n in range(scans):
            yield bags.transform(n, "world", "camera", (0.0, 0.0, 1.0))
            yield bags.cloud(n, image)

    path = bags.write(tmp_path, form, record())
    with Replay(options(path, joint_topic="", taught={}, viewpoint_topic="/viewpoint")) as cell:
        tracemalloc.start()
        cell.move_to(0, "one")
        for _ in range(scans):
            cell.scan(not_before=0.0)
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
    assert peak < 0.5 * scans * 240_000
