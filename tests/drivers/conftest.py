"""A cell on each version of ROS, which all tests of drivers share."""

from collections.abc import Iterator

import pytest

from tests.drivers.ros.fixtures import started
from tests.drivers.ros1 import rig as ros1
from tests.drivers.ros2 import rig as ros2


@pytest.fixture(scope="package")
def ros1_rig(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ros1.Rig]:
    ros1.require_ros()
    yield from started(ros1.Rig, tmp_path_factory)


@pytest.fixture(scope="package")
def ros2_rig(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ros2.Rig]:
    ros2.require_ros2()
    yield from started(ros2.Rig, tmp_path_factory)
