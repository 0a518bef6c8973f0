"""A cell on ROS 2 that the tests of a session share."""

from collections.abc import Iterator

import pytest

from beltsort.drivers.ros2 import Ros2Arm, Ros2Belt, Ros2Camera
from tests.drivers.ros2 import scene
from tests.drivers.ros2.rig import Rig, require_ros2


@pytest.fixture(scope="package")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Rig]:
    require_ros2()
    directory = tmp_path_factory.mktemp("ros2")
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
def shared_camera(shared: Rig) -> Iterator[Ros2Camera]:
    with Ros2Camera(scene.camera_by_tf(shared.domain)) as camera:
        yield camera


@pytest.fixture(scope="package")
def shared_arm(shared: Rig) -> Iterator[Ros2Arm]:
    with Ros2Arm(scene.arm(shared.domain)) as arm:
        yield arm


@pytest.fixture(scope="package")
def shared_belt(shared: Rig) -> Iterator[Ros2Belt]:
    with Ros2Belt(scene.belt(shared.domain)) as belt:
        yield belt


@pytest.fixture
def camera(rig: Rig, shared_camera: Ros2Camera) -> Ros2Camera:
    return shared_camera


@pytest.fixture
def arm(rig: Rig, shared_arm: Ros2Arm) -> Ros2Arm:
    return shared_arm


@pytest.fixture
def belt(rig: Rig, shared_belt: Ros2Belt) -> Ros2Belt:
    return shared_belt
