"""Each version of ROS: what holds of devices on one holds of those on the other."""

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
from tests.drivers.ros.rig import PeerRig

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


@pytest.fixture(scope="package", params=["Ros1", "Ros2"])
def shared(request: pytest.FixtureRequest) -> PeerRig:
    rig: PeerRig = request.getfixturevalue(f"{request.param.lower()}_rig")
    return rig
