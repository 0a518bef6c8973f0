"""Devices that the tests of a folder share; each folder's conftest.py says on which rig (`shared`)."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TypeVar
from uuid import uuid4

import pytest

from beltsort.drivers.ros.arm import RosArm
from beltsort.drivers.ros.belt import RosBelt
from beltsort.drivers.ros.camera import RosCamera
from tests.drivers.ros.rig import PeerRig, await_ready

SomeRig = TypeVar("SomeRig", bound=PeerRig)


def started(make: Callable[[Path], SomeRig], factory: pytest.TempPathFactory) -> Iterator[SomeRig]:
    """Yield a rig whose nodes, and ours, log into a folder of the tests."""
    folder = factory.mktemp("ros")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ROS_LOG_DIR", str(folder))
        rig = make(folder)
        yield rig
        rig.close()


def an_id() -> str:
    """Return a command id that no other test uses."""
    return uuid4().hex


@pytest.fixture
def rig(shared: PeerRig) -> PeerRig:
    """Return the rig of all tests, its peer running and well-behaved."""
    shared.mend()
    return shared


@pytest.fixture(scope="package")
def shared_camera(shared: PeerRig) -> Iterator[RosCamera]:
    with shared.camera() as camera:
        yield camera


@pytest.fixture(scope="package")
def shared_arm(shared: PeerRig) -> Iterator[RosArm]:
    with shared.arm() as arm:
        yield arm


@pytest.fixture(scope="package")
def shared_acting_arm(shared: PeerRig) -> Iterator[RosArm]:
    with shared.arm(action=True) as arm:
        yield arm


@pytest.fixture(scope="package")
def shared_belt(shared: PeerRig) -> Iterator[RosBelt]:
    with shared.belt() as belt:
        yield belt


# A test before may have killed the peer: a device is given when it has found the new one.


@pytest.fixture
def camera(rig: PeerRig, shared_camera: RosCamera) -> RosCamera:
    await_ready(shared_camera)
    return shared_camera


@pytest.fixture
def arm(rig: PeerRig, shared_arm: RosArm) -> RosArm:
    await_ready(shared_arm)
    return shared_arm


@pytest.fixture
def acting_arm(rig: PeerRig, shared_acting_arm: RosArm) -> RosArm:
    await_ready(shared_acting_arm)
    return shared_acting_arm


@pytest.fixture
def belt(rig: PeerRig, shared_belt: RosBelt) -> RosBelt:
    await_ready(shared_belt)
    return shared_belt
