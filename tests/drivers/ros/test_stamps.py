"""Stamps are brought to the monotonic clock by their age at arrival; no ROS is needed."""

from types import SimpleNamespace
from typing import Any

import pytest

from beltsort.drivers.ros.serving import Arrived, answered


def message(stamp: float) -> Any:
    header = SimpleNamespace(stamp=SimpleNamespace(to_sec=lambda: stamp))
    return SimpleNamespace(header=header, data=b"points", _connection_header={"callerid": "/camera"})


def newest(stamp: float, ros_time: float, at: float, not_before: float = 0.0) -> tuple[dict[str, Any], bytes]:
    """Return what the node answers about a message that arrived at `at`, when ROS had `ros_time`."""
    return answered(Arrived(1, at, ros_time, message(stamp)), not_before)


@pytest.mark.parametrize("set_by", [0.0, -3600.0, 3600.0])
def test_a_clock_that_is_set_changes_no_order(set_by: float) -> None:
    """A cloud is exposed 0.2 s before it arrives, once before the arm stops and once after."""
    stopped, wall = 50.0, 1.7e9 + set_by
    before, _ = newest(wall + 49.7, wall + 49.9, at=49.9)
    after, data = newest(wall + 50.1, wall + 50.3, at=50.3, not_before=stopped)
    assert before["stamp"] == pytest.approx(49.7)
    assert after["stamp"] == pytest.approx(50.1)
    assert before["stamp"] < stopped <= after["stamp"]
    assert data == b"points"


def test_a_buffered_cloud_is_not_taken_for_a_new_one_when_the_clock_was_set_back() -> None:
    """Its stamp is from before the clock was set back, and so far ahead of all others."""
    answer, _ = newest(stamp=1000.0, ros_time=400.0, at=50.3)
    assert answer["ahead"] == pytest.approx(600.0), "which the camera refuses"


def test_a_message_without_a_stamp_is_of_its_arrival() -> None:
    answer, _ = newest(stamp=0.0, ros_time=400.0, at=50.3)
    assert (answer["stamp"], answer["ros_stamp"], answer["ahead"]) == (50.3, 400.0, 0.0)
