"""Scans from depth images."""

import time

import numpy as np
import pytest

from beltsort.cell import CommandError
from tests.drivers.ros2.rig import Rig
from tests.drivers.ros2.topics import DEPTH, INFO

pytestmark = pytest.mark.process


def test_a_depth_image_is_a_scan(rig: Rig) -> None:
    with rig.camera(topic="", depth_topic=DEPTH, info_topic=INFO) as camera:
        points = camera.scan(not_before=time.monotonic(), timeout=10.0).points
        assert points.shape == (2, 3, 3)
        np.testing.assert_allclose(points[0, 2], [0.6 / 500, -0.5 * 0.6 / 400, 0.6])
        assert np.isnan(points[0, 1]).all()
        rig.tell(cloud="truncated")
        with pytest.raises(CommandError, match=r"\bimage is truncated: 11 bytes\b"):
            camera.scan(not_before=time.monotonic(), timeout=1.0)
