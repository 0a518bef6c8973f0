"""The devices of ROS 1."""

import pytest

from tests.drivers.ros.fixtures import (
    acting_arm,
    arm,
    belt,
    camera,
    rig,
    shared_acting_arm,
    shared_arm,
    shared_belt,
    shared_camera,
)
from tests.drivers.ros1.rig import Rig

__all__ = [
    "acting_arm",
    "arm",
    "belt",
    "camera",
    "rig",
    "shared_acting_arm",
    "shared_arm",
    "shared_belt",
    "shared_camera",
]


@pytest.fixture(scope="package")
def shared(ros1_rig: Rig) -> Rig:
    return ros1_rig
