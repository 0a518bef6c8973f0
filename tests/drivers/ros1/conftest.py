"""A cell on ROS 1 that the tests of a session share."""

from collections.abc import Iterator

import pytest

from beltsort.drivers.ros1 import Ros1Arm, Ros1Belt, Ros1Camera
from tests.drivers.ros1 import scene
from tests.drivers.ros1.rig import Rig, require_ros


@pytest.fixture(scope="package")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Rig]:
    require_ros()
    directory = tmp_path_factory.mktemp("ros")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ROS_LOG_DIR", str(directory))
        rig = Rig(directory)
        yield rig
        rig.close()


@pytest.fixture
def rig(shared: Rig) -> Rig:
    """Return the rig of all tests, its peer running and well-behaved."""
    shared.mend()
    return shared


@pytest.fixture(scope="package")
def shared_camera(shared: Rig) -> Iterator[Ros1Camera]:
    with Ros1Camera(scene.camera_by_tf(shared.uri)) as camera:
        yield camera


@pytest.fixture(scope="package")
def shared_arm(shared: Rig) -> Iterator[Ros1Arm]:
    with Ros1Arm(scene.arm(shared.uri)) as arm:
        yield arm


@pytest.fixture(scope="package")
def shared_belt(shared: Rig) -> Iterator[Ros1Belt]:
    with Ros1Belt(scene.belt(shared.uri)) as belt:
        yield belt


@pytest.fixture
def camera(rig: Rig, shared_camera: Ros1Camera) -> Ros1Camera:
    return shared_camera


@pytest.fixture
def arm(rig: Rig, shared_arm: Ros1Arm) -> Ros1Arm:
    return shared_arm


@pytest.fixture
def belt(rig: Rig, shared_belt: Ros1Belt) -> Ros1Belt:
    return shared_belt
