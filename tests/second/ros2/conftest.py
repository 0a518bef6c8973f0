"""The peer in Rust, in the place of that of tests/drivers/ros2."""

import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from beltsort.drivers.ros2 import Ros2Belt
from tests.drivers.ros2 import scene
from tests.drivers.ros2.conftest import arm, belt, rig, shared_arm
from tests.drivers.ros2.rig import ROOT, Rig, require_ros2

__all__ = ["arm", "belt", "rig", "shared_arm"]

TARGET = ROOT / "target" / "ros2-peer"
"""Where the peer is built, and kept for the next time."""


@pytest.fixture(scope="package")
def binary() -> Path:
    """Build the peer: four minutes the first time."""
    manifest = str(Path(__file__).with_name("Cargo.toml"))
    command = ["cargo", "build", "--release", "--locked", "--manifest-path", manifest, "--target-dir"]
    subprocess.run([*command, str(TARGET)], check=True)
    return TARGET / "release" / "ros2-peer"


@pytest.fixture(scope="package")
def shared(binary: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Rig]:
    require_ros2()
    directory = tmp_path_factory.mktemp("ros2")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ROS_LOG_DIR", str(directory))
        rig = Rig(directory, str(binary))
        yield rig
        rig.close()


@pytest.fixture(scope="package")
def shared_belt(shared: Rig) -> Iterator[Ros2Belt]:
    with Ros2Belt(scene.belt(shared.domain)) as belt:
        belt.connect()  # the first test gives it less time than a busy machine takes
        yield belt
